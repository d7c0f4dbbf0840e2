#pragma once
// What one particle with an affine field reads from its tile: quadratic splines, velocities alone.
//
//   velocity = sum w v'     gradient[b] = sum v' dw/d(x_b / h)     affine[b] = sum w v' (x_i - x_p)_b / (h D)
//
// Along an axis, with the steps s_0 = v_1 - v_0 and s_1 = v_2 - v_1, the bend d = s_1 - s_0, the place f in the binning
// cell and c = f - 1/2:
//
//   sum w v                      =  v_1 - w_0 s_0 + w_2 s_1
//   sum dw v                     =  s_0 + f d
//   sum w v (x_i - x_p) / (h D)  =  sum dw v + c (1/2 - 2 c^2) d
//
// The last because D = 1/4, and both sums give a linear field its slope and a constant nothing: on three nodes they can
// differ by a multiple of d alone. Steps are shared by all three, so APIC takes fewer products than FLIP, and no
// register for levers (Jiang et al. 2015, eq. 10 has the sum as it stands).

#include "core/grid/shape.hpp"
#include "gpu/kernels/g2p/gather.cuh"

namespace moraine::gpu {

// Apart from the levers of gather.cuh, which the split gather has for every shape and for both quads. With them the 18
// fused kernels of 3-D in single precision (sm_90) grow by 159 to 196 instructions each (von Mises: 2922 to 3117),
// three of them divisions, and the 7 that hold 96 registers spill 24 to 32 bytes, where now none does.

/// A quadratic spline along one axis.
template <class Real>
struct SplineAxis {
    Real f;     ///< place in the binning cell [cells]
    Real w[3];  ///< weights
    Real lack;  ///< of the bend, what the gradient lacks of C; 0 where C is the gradient
};

template <class Real>
__device__ __forceinline__ SplineAxis<Real> spline_axis(Real f, bool plain) {
    SplineAxis<Real> axis;
    Real slopes[3];
    axis.f = f;
    Quadratic::weights(f, Real(0), axis.w, slopes);
    const Real c = f - Real(0.5);
    axis.lack = plain ? Real(0) : c * std::fma(Real(-2) * c, c, Real(0.5));
    return axis;
}

/// Three values in a row: the middle one and the steps.
template <class Real, int Dim>
struct Steps {
    Real middle[Dim], first[Dim], second[Dim];
};

template <class Real, int Dim>
__device__ __forceinline__ Steps<Real, Dim> steps_between(const Real (&a)[Dim], const Real (&b)[Dim],
                                                          const Real (&c)[Dim]) {
    Steps<Real, Dim> s;
#pragma unroll
    for (int q = 0; q < Dim; ++q) s.middle[q] = b[q], s.first[q] = b[q] - a[q], s.second[q] = c[q] - b[q];
    return s;
}

template <class Real, int Dim>
__device__ __forceinline__ Steps<Real, Dim> steps_of(const NodeTile<Real, Dim, 3, false>& tile, std::ptrdiff_t at) {
    return steps_between(tile.get(at).v, tile.get(at + 1).v, tile.get(at + 2).v);
}

template <class Real, int Dim>
__device__ __forceinline__ Steps<Real, Dim> steps_of(const StepTile<Real, Dim, 3, false>& tile, std::ptrdiff_t at) {
    const NodeValue<Real, Dim, false> b = tile.node.get(at + 1), s0 = tile.step.get(at), s1 = tile.step.get(at + 1);
    Steps<Real, Dim> s;
#pragma unroll
    for (int q = 0; q < Dim; ++q) s.middle[q] = b.v[q], s.first[q] = s0.v[q], s.second[q] = s1.v[q];
    return s;
}

/// Sums along one axis.
template <class Real, int Dim>
struct Along {
    Real value[Dim], slope[Dim], bend[Dim];
};

template <class Real, int Dim>
__device__ __forceinline__ Along<Real, Dim> along(const Steps<Real, Dim>& s, const SplineAxis<Real>& n) {
    Along<Real, Dim> sums;
#pragma unroll
    for (int q = 0; q < Dim; ++q) {
        sums.bend[q] = s.second[q] - s.first[q];
        sums.slope[q] = std::fma(n.f, sums.bend[q], s.first[q]);
        sums.value[q] = std::fma(n.w[2], s.second[q], std::fma(-n.w[0], s.first[q], s.middle[q]));
    }
    return sums;
}

/// Sums over axes: the value, and by axis what its slope and its bend came to.
template <class Real, int Dim, int Axes>
struct Bent {
    Real value[Dim], slope[Axes][Dim], bend[Axes][Dim];
};

template <class Real, int Dim, class Tile>
__device__ __forceinline__ Bent<Real, Dim, 2> bent_plane(const Tile& tile, std::ptrdiff_t at,
                                                         const SplineAxis<Real> (&n)[Dim]) {
    Bent<Real, Dim, 2> plane;
    Real value[3][Dim];
#pragma unroll
    for (int j = 0; j < 3; ++j) {
        const Along<Real, Dim> line = along(steps_of(tile, at + tile_side(3) * j), n[0]);
        accumulate(j == 0, n[1].w[j], line.slope, plane.slope[0]);
        accumulate(j == 0, n[1].w[j], line.bend, plane.bend[0]);
#pragma unroll
        for (int q = 0; q < Dim; ++q) value[j][q] = line.value[q];
    }
    const Along<Real, Dim> lines = along(steps_between(value[0], value[1], value[2]), n[1]);
#pragma unroll
    for (int q = 0; q < Dim; ++q)
        plane.value[q] = lines.value[q], plane.slope[1][q] = lines.slope[q], plane.bend[1][q] = lines.bend[q];
    return plane;
}

template <class Real, class Tile>
__device__ __forceinline__ Bent<Real, 2, 2> bent(const Tile& tile, std::ptrdiff_t at, const SplineAxis<Real> (&n)[2]) {
    return bent_plane(tile, at, n);
}

template <class Real, class Tile>
__device__ __forceinline__ Bent<Real, 3, 3> bent(const Tile& tile, std::ptrdiff_t at, const SplineAxis<Real> (&n)[3]) {
    constexpr int side = tile_side(3);
    Bent<Real, 3, 3> all;
    Real value[3][3];
#pragma unroll
    for (int k = 0; k < 3; ++k) {
        const Bent<Real, 3, 2> plane = bent_plane(tile, at + side * side * k, n);
#pragma unroll
        for (int b = 0; b < 2; ++b) {
            accumulate(k == 0, n[2].w[k], plane.slope[b], all.slope[b]);
            accumulate(k == 0, n[2].w[k], plane.bend[b], all.bend[b]);
        }
#pragma unroll
        for (int q = 0; q < 3; ++q) value[k][q] = plane.value[q];
    }
    const Along<Real, 3> planes = along(steps_between(value[0], value[1], value[2]), n[2]);
#pragma unroll
    for (int q = 0; q < 3; ++q)
        all.value[q] = planes.value[q], all.slope[2][q] = planes.slope[q], all.bend[2][q] = planes.bend[q];
    return all;
}

/// at: tile offset of the particle's cell. What changes nodes is not gathered.
template <class Real, int Dim, class Tile>
__device__ __forceinline__ Gathered<Real, Dim, true> gather_affine(const Tile& tile, std::ptrdiff_t at,
                                                                   const SplineAxis<Real> (&n)[Dim]) {
    const Bent<Real, Dim, Dim> sums = bent(tile, at, n);
    Gathered<Real, Dim, true> g;
#pragma unroll
    for (int q = 0; q < Dim; ++q) {
        g.velocity[q] = sums.value[q];
#pragma unroll
        for (int b = 0; b < Dim; ++b) {
            g.gradient[b][q] = sums.slope[b][q];
            g.affine[b][q] = std::fma(n[b].lack, sums.bend[b][q], sums.slope[b][q]);
        }
    }
    return g;
}

}  // namespace moraine::gpu
