#pragma once
// How much of this step's acceleration a particle's velocity gradient takes, where its nodes hold little mass.
//
// A node is accelerated by f_i / m_i, so a stress answers its own change by what one step multiplies it with:
//   R_b = (c dt)^2 sum_i (dw_ip/dx_b)^2 r_ip per axis b,    r_ip = min(1 / w_ip, M_p / m_i)
//   M_p = min(sum of the masses of the particle's nodes, rho_p h^d)
// r_ip is 1 in a full body and 1 / w_ip of a particle alone. Nodes that a wall or a structure holds along b, v_ib' = 0,
// are left out of R_b: they answer no stress, and a share that counts them is less than what the particles of a group
// keep, which swings up. A step is stable while its R stays below 2 to 4. R has no
// bound where a spline is folded at a wall (there a node's weight goes to 0 and its slope does not), and the axes of a
// particle alone together exceed it in its pressure. So with the velocity v_i of the nodes before forces and v_i'
// after:
//   dL_p / dt = grad v + T(grad (v' - v))
// T multiplies component c, b by the lesser share of its two axes, min(1, limit / R_b) along folded ones, then the
// trace by min(1, limit / (e sum of R_b)), where e = (lambda + 2G/d) / (lambda + 2G). Both halves of a shear rate have
// one share: with du_x/dy limited and du_y/dx not, a layer swings up on a no-slip wall. What is taken of a trace falls
// to the axes as their R_b, as a pressure made it: taken evenly it leaves an axis of a small R a rate of the wrong
// sign, which no fluid resists. C_p is treated alike, with the squares of the shares (with MUSL the first power of
// the trace's): what a particle keeps of an acceleration must be less than what its stress has seen of it, or the
// two swing up. A particle alone is stable while
//   L < 2 + K L^2 / (2 R^2),   L = limit, R = e sum of R_b, K what C keeps of its own pressure, 2R/3 or more
// so the trace's limit falls from 2.5 to 2 + 1.5 / R (APIC, TPIC). v here is after the walls, so that what a wall takes
// from a particle that comes to it is not an acceleration. Momentum is that of the nodes, untouched; at rest, and as dt
// goes to 0, nothing changes; a particle whose nodes all hold half of a full one or more is not looked at.
// docs/adr/0006 compares it with other ways.

#include "core/data/vec.hpp"

namespace moraine {

/// Elastic moduli of a body's material at the start, and what it gives a full node.
template <class Real>
struct Stiffness {
    Real wave;       ///< lambda + 2 G [Pa]
    Real dilation;   ///< (lambda + 2 G / d) over it [-]
    Real full_mass;  ///< rho h^d, of a full node [kg]
};

/// Largest reactions that a method's step bears [-].
template <class Real>
struct ReactionLimits {
    Real wall;    ///< of one folded axis
    Real volume;  ///< of the pressure
    Real alone;   ///< of the pressure, where it is large
    bool mapped;  ///< the stress sees what the particles kept (MUSL)

    /// Of the pressure, by its reaction.
    MORAINE_HD Real of(Real reaction) const {
        const Real most = alone + Real(1.5) / reaction;
        return most < volume ? most : volume;
    }
};

/// What is left of an acceleration's gradient, as what it follows from: it is asked for where a gather has registers
/// for less.
template <class Real, int Dim>
struct LightShare {
    Vec<Real, Dim> reaction;  ///< R_b of each axis
    bool limited[Dim];        ///< by the limit of a folded one
    Real sum;                 ///< of them, those at their limits
    Real together;            ///< of the pressure: e times the sum
    bool whole;               ///< all of it is left

    /// Of a column; in C its square.
    MORAINE_HD Real axis(const ReactionLimits<Real>& limits, int b) const {
        return limited[b] ? limits.wall / reaction[b] : Real(1);
    }
    /// Of an axis in what is taken of the trace.
    MORAINE_HD Real part(const ReactionLimits<Real>& limits, int b) const {
        return (limited[b] ? limits.wall : reaction[b]) / sum;
    }
    /// Of the trace of what the axes leave; in C its square, unless the stress sees what is kept.
    MORAINE_HD Real volume(const ReactionLimits<Real>& limits) const {
        const Real most = limits.of(together);
        return together > most ? most / together : Real(1);
    }
};

/// (dw / w)^2 along one axis [1/m2].
template <class Real>
MORAINE_HD Real steepness(Real w, Real dw) {
    const Real ratio = w > Real(0) ? dw / w : Real(0);
    return ratio * ratio;
}

/// w^2 r of a node, with M_p / m_i: times the steepness along an axis its part of the reaction per (c dt)^2.
template <class Real>
MORAINE_HD Real reacting_weight(Real w, Real mass_ratio) {
    const Real share = w * mass_ratio;
    return share < Real(1) ? w * share : w;
}

/// From the reactions of one particle.
template <class Real, int Dim>
MORAINE_HD LightShare<Real, Dim> light_share(const ReactionLimits<Real>& limits, const Vec<Real, Dim>& reaction,
                                             const bool* folded, Real dilation) {
    LightShare<Real, Dim> share;
    share.reaction = reaction;
    share.whole = true;
    share.sum = Real(0);
    for (int b = 0; b < Dim; ++b) {
        share.limited[b] = folded[b] && reaction[b] > limits.wall;
        if (share.limited[b]) share.whole = false;
        share.sum += share.limited[b] ? limits.wall : reaction[b];
    }
    share.together = dilation * share.sum;
    if (share.together > limits.of(share.together)) share.whole = false;
    return share;
}

/// What the share takes from a gradient: T(a) - a. kept: from C.
template <class Real, int Dim>
MORAINE_HD Mat<Real, Dim> taken_from(const Mat<Real, Dim>& a, const ReactionLimits<Real>& limits,
                                     const LightShare<Real, Dim>& share, bool kept) {
    Mat<Real, Dim> taken;
    Real left = Real(0), volume = share.volume(limits);
    if (kept && !limits.mapped) volume *= volume;
    for (int b = 0; b < Dim; ++b) {
        const Real axis = share.axis(limits, b);
        for (int c = 0; c < Dim; ++c) {
            const Real other = share.axis(limits, c);
            Real least = axis < other ? axis : other;
            if (kept) least *= least;
            taken(c, b) = (least - Real(1)) * a(c, b);
            if (c == b) left += least * a(b, b);
        }
    }
    if (volume < Real(1))
        for (int b = 0; b < Dim; ++b) taken(b, b) += (volume - Real(1)) * left * share.part(limits, b);
    return taken;
}

}  // namespace moraine
