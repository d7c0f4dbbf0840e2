#pragma once
// What one particle reads from its tile: nested sums over the stencil, along x, then y, then z.
//
//   velocity = sum w v'     change = sum w dv     gradient[b] = sum v' dw/d(x_b / h)
//   affine[b] = sum w v' (x_i - x_p)_b / (h D_b)  where APIC is wanted (or the gradient: core/grid/particle_update.hpp)
//
// Nested: for quadratic 3-D 9 + 4 + 5/3 products of three per node instead of 18. Slopes are per cell here; whoever
// uses a gradient multiplies by 1/h. The cell is the top bits of the place, so no cell list is read.

#include "core/grid/particle_update.hpp"
#include "core/grid/shape.hpp"
#include "gpu/kernels/g2p/gather_tile.cuh"

namespace moraine::gpu {

template <class Real, int Dim, bool Affine>
struct Gathered {
    Real velocity[Dim];
    Real change[Dim];
    Real gradient[Dim][Dim];                          ///< [axis of the slope][component]
    Real affine[Affine ? Dim : 1][Affine ? Dim : 1];  ///< likewise
};

/// Weights of one axis; without Affine no levers.
template <class Real, class Shape, bool Affine>
struct AxisWeights {
    Real w[Shape::width];
    Real dw[Shape::width];                  ///< per cell
    Real lever[Affine ? Shape::width : 1];  ///< w (x_i - x_p) / D [1/cell]
};

template <class Shape, bool Affine, class Real>
__device__ __forceinline__ AxisWeights<Real, Shape, Affine> axis_weights(Real f, Real half, bool plain) {
    AxisWeights<Real, Shape, Affine> n;
    Shape::weights(f, half, n.w, n.dw);
    if constexpr (Affine) affine_levers<Shape>(f, n.w, n.dw, Real(1), plain, n.lever);
    return n;
}

/// to = sum over i of factor x, one line or plane after the other.
template <int Dim, class Real>
__device__ __forceinline__ void accumulate(bool first, Real factor, const Real (&x)[Dim], Real (&to)[Dim]) {
#pragma unroll
    for (int q = 0; q < Dim; ++q) to[q] = first ? factor * x[q] : std::fma(factor, x[q], to[q]);
}

/// Sums along x: of w v', of w dv, of dw v', of lever v'.
template <class Real, int Dim, bool Affine>
struct Line {
    Real v[Dim], dv[Dim], slope[Dim], lever[Affine ? Dim : 1];

    __device__ __forceinline__ void add(bool first, Real w, Real dw, Real l, const NodeValue<Real, Dim>& x) {
        accumulate(first, w, x.v, v);
        accumulate(first, w, x.dv, dv);
        accumulate(first, dw, x.v, slope);
        if constexpr (Affine) accumulate(first, l, x.v, lever);
    }
};

template <class Shape, bool Affine, class Real, int Dim>
__device__ __forceinline__ Line<Real, Dim, Affine> line_of(const NodeTile<Real, Dim, Shape::width>& tile,
                                                           std::ptrdiff_t at,
                                                           const AxisWeights<Real, Shape, Affine>& n) {
    Line<Real, Dim, Affine> line;
#pragma unroll
    for (int i = 0; i < Shape::width; ++i)
        line.add(i == 0, n.w[i], n.dw[i], Affine ? n.lever[i % (Affine ? Shape::width : 1)] : Real(0),
                 tile.get(at + i));
    return line;
}

/// By node 1 and the steps: step 0 counts -w_0, step i the weights beyond it.
template <class Shape, bool Affine, class Real, int Dim>
__device__ __forceinline__ Line<Real, Dim, Affine> line_of(const StepTile<Real, Dim, Shape::width>& tile,
                                                           std::ptrdiff_t at,
                                                           const AxisWeights<Real, Shape, Affine>& n) {
    constexpr int width = Shape::width;
    const NodeValue<Real, Dim> middle = tile.node.get(at + 1);
    Line<Real, Dim, Affine> line;
#pragma unroll
    for (int q = 0; q < Dim; ++q) line.v[q] = middle.v[q], line.dv[q] = middle.dv[q];
#pragma unroll
    for (int i = 0; i < width - 1; ++i) {
        Real w = Real(0), dw = Real(0), lever = Real(0);
#pragma unroll
        for (int j = (i == 0 ? 0 : i + 1); j < (i == 0 ? 1 : width); ++j) {
            w += n.w[j], dw += n.dw[j];
            if constexpr (Affine) lever += n.lever[j];
        }
        if (i == 0) w = -w, dw = -dw, lever = -lever;
        const NodeValue<Real, Dim> x = tile.step.get(at + i);
        accumulate(false, w, x.v, line.v);
        accumulate(false, w, x.dv, line.dv);
        accumulate(i == 0, dw, x.v, line.slope);
        if constexpr (Affine) accumulate(i == 0, lever, x.v, line.lever);
    }
    return line;
}

/// Sums over a plane of lines: of v', dv, and of v' with the slope or lever of x or y.
template <class Real, int Dim, bool Affine>
struct Plane {
    Real v[Dim], dv[Dim], slope[2][Dim], lever[2][Affine ? Dim : 1];
};

template <class Shape, bool Affine, class Real, int Dim, class Tile>
__device__ __forceinline__ Plane<Real, Dim, Affine> plane_of(const Tile& tile, std::ptrdiff_t at,
                                                             const AxisWeights<Real, Shape, Affine> (&n)[Dim]) {
    Plane<Real, Dim, Affine> plane;
#pragma unroll
    for (int j = 0; j < Shape::width; ++j) {
        const Line<Real, Dim, Affine> line =
            line_of<Shape, Affine, Real, Dim>(tile, at + tile_side(Shape::width) * j, n[0]);
        accumulate(j == 0, n[1].w[j], line.v, plane.v);
        accumulate(j == 0, n[1].w[j], line.dv, plane.dv);
        accumulate(j == 0, n[1].w[j], line.slope, plane.slope[0]);
        accumulate(j == 0, n[1].dw[j], line.v, plane.slope[1]);
        if constexpr (Affine) {
            accumulate(j == 0, n[1].w[j], line.lever, plane.lever[0]);
            accumulate(j == 0, n[1].lever[j], line.v, plane.lever[1]);
        }
    }
    return plane;
}

/// at: tile offset of the particle's cell. Rolled: plane by plane in a loop, with fewer registers.
template <class Shape, bool Affine, class Real, int Dim, bool Rolled = false, class Tile>
__device__ __forceinline__ Gathered<Real, Dim, Affine> gather(const Tile& tile, std::ptrdiff_t at,
                                                              const AxisWeights<Real, Shape, Affine> (&n)[Dim]) {
    constexpr int side = tile_side(Shape::width);
    Gathered<Real, Dim, Affine> g;
#pragma unroll(Rolled ? 1 : Shape::width)
    for (int k = 0; k < (Dim == 3 ? Shape::width : 1); ++k) {
        const Plane<Real, Dim, Affine> plane = plane_of<Shape, Affine, Real, Dim>(tile, at + side * side * k, n);
        const Real w = Dim == 3 ? n[Dim - 1].w[k] : Real(1);
        accumulate(k == 0, w, plane.v, g.velocity);
        accumulate(k == 0, w, plane.dv, g.change);
        accumulate(k == 0, w, plane.slope[0], g.gradient[0]);
        accumulate(k == 0, w, plane.slope[1], g.gradient[1]);
        if constexpr (Affine) {
            accumulate(k == 0, w, plane.lever[0], g.affine[0]);
            accumulate(k == 0, w, plane.lever[1], g.affine[1]);
        }
        if constexpr (Dim == 3) {
            accumulate(k == 0, n[2].dw[k], plane.v, g.gradient[2]);
            if constexpr (Affine) accumulate(k == 0, n[2].lever[k], plane.v, g.affine[2]);
        }
    }
    return g;
}

}  // namespace moraine::gpu
