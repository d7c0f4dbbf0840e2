#pragma once
// The stencil of one particle: weights and slopes per axis.

#include "core/data/position.hpp"
#include "core/grid/particle_update.hpp"
#include "core/grid/shape.hpp"
#include "core/grid/walls.hpp"
#include "core/particles/particle_state.hpp"

namespace moraine {

/// Weights and slopes of one particle. Slopes are per metre.
template <class Real, int Dim, class Shape>
struct Weights {
    Real w[Dim][Shape::width];
    Real dw[Dim][Shape::width];
    Real f[Dim];  ///< place in the binning cell [cells]
};

/// Half-sizes of the GIMP box of each body per axis at ln stretch 0 [cells].
template <class Real, int Dim>
using HalfSizes = const Vec<Real, Dim>*;

/// What all stencils of a run share.
template <class Real, int Dim>
struct StencilContext {
    Walls<Real, Dim> walls;
    Real inverse_cell;               ///< 1/h [1/m]
    HalfSizes<Real, Dim> half_size;  ///< per body, null unless the shape is sized
    Vec<Real, Dim> gravity_slope;    ///< rho g h, zero along periodic axes [Pa] (pressure_smoothing.hpp)
};

template <class Real, int Dim>
MORAINE_HD Real gimp_half(const StencilContext<Real, Dim>& context, const ParticleView<Real, Dim>& p, std::uint32_t s,
                          int axis) {
    const Real half = context.half_size[p.body[s]][axis];
    return held_half(p.log_stretch ? stretched_half(half, p.log_stretch[s][axis]) : half);
}

/// Weights of the particle in slot s.
template <class Real, int Dim, class Shape>
MORAINE_HD Weights<Real, Dim, Shape> stencil(const StencilContext<Real, Dim>& context, const ParticleView<Real, Dim>& p,
                                             std::uint32_t s) {
    Weights<Real, Dim, Shape> n;
    for (int a = 0; a < Dim; ++a) {
        n.f[a] = fraction_of<Real>(p.position[s][a]);
        Real half = Real(0);
        if constexpr (Shape::sized) half = gimp_half(context, p, s, a);
        Shape::weights(n.f[a], half, n.w[a], n.dw[a]);
        for (int i = 0; i < Shape::width; ++i) n.dw[a][i] *= context.inverse_cell;
    }
    return n;
}

/// Calls f(tile offset of the node, i, j, k) for each node of a stencil, x fastest. Unrolled: what a device's compiler
/// makes of it, where light nodes ask for it; on a host it has its own mind.
template <int Dim, int Width, bool Unrolled = false, class F>
MORAINE_HD void each_node(const F& f) {
    constexpr int side = tile_side(Width), layers = Dim == 2 ? 1 : Width;
#ifdef __CUDA_ARCH__
    constexpr int rows = Unrolled ? Width : 1;
#pragma unroll rows
    for (int k = 0; k < layers; ++k)
#pragma unroll rows
        for (int j = 0; j < Width; ++j)
#pragma unroll
            for (int i = 0; i < Width; ++i) f(i + side * (j + side * k), i, j, k);
#else
    for (int k = 0; k < layers; ++k)
        for (int j = 0; j < Width; ++j)
            for (int i = 0; i < Width; ++i) f(i + side * (j + side * k), i, j, k);
#endif
}

/// Offset in a tile of the stencil of a cell: the cell's coordinates are those of its lowest node.
template <int Dim, int Width>
MORAINE_HD int tile_offset(int cell) {
    constexpr int side = tile_side(Width);
    const int x = cell & 3;
    const int y = (cell >> 2) & 3;
    return Dim == 2 ? x + side * y : x + side * (y + side * (cell >> 4));
}

template <int Dim>
MORAINE_HD int cell_coordinate(int cell, int axis) {
    return (cell >> (2 * axis)) & 3;
}

}  // namespace moraine
