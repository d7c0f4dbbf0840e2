#pragma once
// What a particle makes of what it gathered, as functions of values: for the loops of the host and of devices alike.
//
//   v <- a (v + sum w dv) + (1 - a) v_pic         a: share of FLIP (Zhu and Bridson 2005)
//   C = sum v_i' g_i,  dL = dt sum v_i' grad w    g = grad w (TPIC) or w (x_i - x_p) / D (APIC; Jiang et al. 2015)
//   ln s <- ln s + ln(1 + dL_aa)                  stretch of a contiguous GIMP box of half-size l = min(l_0 s, 1/2)
//
// Nothing here knows where a particle lies in memory, or who sums the nodes: those are the loops
// (core/transfer/g2p.hpp, gpu/kernels/g2p), which are written twice (docs/adr/0004). Motion is in place_step.hpp,
// strain and stress are in strain.hpp and stress.hpp, means over a cell in volumetric.hpp.

#include <cmath>
#include <cstdint>

#include "core/data/vec.hpp"
#include "core/grid/walls.hpp"

namespace moraine {

/// What a round of a scheme takes from the nodes (bits).
enum Gather : unsigned {
    gather_velocity = 1,      ///< v_p and C_p
    gather_motion = 2,        ///< x_p, by the first quad
    gather_gradient = 4,      ///< dL and stress, by the first quad
    gather_second_motion = 8  ///< x_p, by the second quad (MUSL: the velocity of round one)
};

/// Whether the round moves particles.
MORAINE_HD constexpr bool moves_particles(unsigned gather) {
    return (gather & (gather_motion | gather_second_motion)) != 0;
}

/// The velocity that the round moves a particle by, or a component of it; first, second: sums of the quads [m/s].
template <class Velocity>
MORAINE_HD Velocity moving_velocity(unsigned gather, const Velocity& first, const Velocity& second) {
    return gather & gather_motion ? first : second;
}

/// Component of a particle's velocity after the round [m/s]. change: sum w dv; gathered: sum w v'.
template <class Real>
MORAINE_HD Real blended_velocity(Real flip, Real velocity, Real change, Real gathered) {
    using std::fma;
    const Real full = velocity + change;
    return flip == Real(1) ? full : fma(flip, full - gathered, gathered);
}

/// The tensor (component, axis) of gathered slopes [axis][component], times `scale`: dL, or C.
template <int Dim, class Real, class Slopes>
MORAINE_HD Mat<Real, Dim> tensor_of(Real scale, const Slopes& slopes) {
    Mat<Real, Dim> m;
    for (int a = 0; a < Dim; ++a)
        for (int b = 0; b < Dim; ++b) m(a, b) = scale * slopes[b][a];
    return m;
}

/// Index along an axis of the first node of a block's tile; the stencil of a cell begins as many nodes above it as the
/// cell's coordinate in the block says.
template <class Shape>
MORAINE_HD int first_node(std::int32_t block) {
    return 4 * block - Shape::origin;
}

/// Whether the stencil of a cell reaches a ghost node along axis a that is folded; cell: its coordinate in the block.
template <class Shape, class Real, int Dim>
MORAINE_HD bool reaches_ghost(const Walls<Real, Dim>& walls, int a, std::int32_t block, int cell) {
    return walls.ghosts(a, first_node<Shape>(block) + cell, Shape::width) != 0;
}

/// Whether the affine field is the velocity gradient along an axis: TPIC; hats, which have no other; and where a ghost
/// node was folded, for there APIC's D tends to zero. folded(): whether one was, asked last.
template <class Shape, class Folded>
MORAINE_HD bool affine_is_gradient(bool tpic, const Folded& folded) {
    return tpic || Shape::width == 2 || folded();
}

/// Factors of v_i' in the affine field along one axis: w (x_i - x_p) / D, or the slopes dw. f: place in the binning
/// cell; inverse_cell: 1/h in the unit of dw.
template <class Shape, class Real>
MORAINE_HD void affine_levers(Real f, const Real* w, const Real* dw, Real inverse_cell, bool is_gradient, Real* lever) {
    Real D = Real(0);
    for (int i = 0; i < Shape::width; ++i) {
        const Real d = Real(i) - f - Shape::template reach<Real>;
        lever[i] = w[i] * d;
        D += lever[i] * d;
    }
    const Real scale = inverse_cell / D;
    for (int i = 0; i < Shape::width; ++i) lever[i] = is_gradient ? dw[i] : lever[i] * scale;
}

/// ln stretch of a contiguous GIMP box along an axis after a step; dL: of that axis.
template <class Real>
MORAINE_HD Real advanced_stretch(Real ln_stretch, Real dL) {
    using std::log1p;
    return ln_stretch + log1p(dL);
}

/// Half-size of a box that began with `half` [cells].
template <class Real>
MORAINE_HD Real stretched_half(Real half, Real ln_stretch) {
    using std::exp;
    return half * exp(ln_stretch);
}

/// Half-size with which a box of half-size `half` enters the shape function [cells].
template <class Real>
MORAINE_HD Real held_half(Real half) {
    return half < Real(0.5) ? half : Real(0.5);
}

}  // namespace moraine
