#pragma once
// How much of this step's acceleration a particle's velocity gradient takes, where its nodes hold little mass.
//
// A node is accelerated by f_i / m_i, so a stress answers its own change by what one step multiplies it with:
//   R_b = (c dt)^2 sum_i (dw_ip/dx_b)^2 r_ip per axis b,    r_ip = min(1 / w_ip, M_p / m_i)
//   M_p = min(sum of the masses of the particle's nodes, rho_p h^d)
// r_ip is 1 in a full body and 1 / w_ip of a particle alone. A step is stable while its R stays below 2 to 4. R has no
// bound where a spline is folded at a wall (there a node's weight goes to 0 and its slope does not), and the axes of a
// particle alone together exceed it in its pressure. So with the velocity v_i of the nodes before forces and v_i'
// after:
//   dL_p / dt = grad v + T(grad (v' - v))
// T multiplies column b by min(1, limit / R_b) along folded axes, then the trace by min(1, limit / (e sum of R_b)),
// where e = (lambda + 2G/d) / (lambda + 2G). What is taken of a trace falls to the axes as their R_b, as a pressure
// made it: taken evenly it leaves an axis of a small R a rate of the wrong sign, which no fluid resists. C_p is treated
// alike, with the squares of the shares (with MUSL the first power of the trace's): what a particle keeps of an
// acceleration must be less than what its stress has seen of it, or the two swing up. A particle alone is stable while
//   L < 2 + K L^2 / (2 R^2),   L = limit, R = e sum of R_b, K what C keeps of its own pressure, 2R/3 or more
// so the trace's limit falls from 2.5 to 2 + 1.5 / R (APIC, TPIC). v here is after the walls, so that what a wall takes
// from a particle that comes to it is not an acceleration. Momentum is that of the nodes, untouched; at rest, and as dt
// goes to 0, nothing changes; a particle whose nodes all hold half of a full one or more is not looked at.
// docs/adr/0006 compares it with other ways.

#include "core/vec.hpp"

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

/// What is left of an acceleration's gradient.
template <class Real, int Dim>
struct LightShare {
    Vec<Real, Dim> axis;  ///< of its columns; in C their squares [-]
    Vec<Real, Dim> part;  ///< of each axis in what is taken of the trace
    Real volume;          ///< of the trace of what is left; in C its square, unless `mapped` [-]
    bool mapped;          ///< ReactionLimits::mapped
    bool whole;           ///< all of it is
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
MORAINE_HD LightShare<Real, Dim> light_share(const ReactionLimits<Real>& limits, Vec<Real, Dim> reaction,
                                             const bool* folded, Real dilation) {
    LightShare<Real, Dim> share;
    share.volume = Real(1);
    share.mapped = limits.mapped;
    share.whole = true;
    Real sum = Real(0);
    for (int b = 0; b < Dim; ++b) {
        share.axis[b] = Real(1);
        share.part[b] = Real(0);
        if (folded[b] && reaction[b] > limits.wall) {
            share.axis[b] = limits.wall / reaction[b];
            reaction[b] = limits.wall;
            share.whole = false;
        }
        sum += reaction[b];
    }
    const Real together = dilation * sum;
    if (together > limits.of(together)) {
        share.volume = limits.of(together) / together;
        for (int b = 0; b < Dim; ++b) share.part[b] = reaction[b] / sum;
        share.whole = false;
    }
    return share;
}

/// What the share takes from a gradient: T(a) - a. kept: from C.
template <class Real, int Dim>
MORAINE_HD Mat<Real, Dim> taken_from(const Mat<Real, Dim>& a, const Vec<Real, Dim>& axis, Real volume,
                                     const Vec<Real, Dim>& part, bool kept = false) {
    Mat<Real, Dim> taken;
    Real left = Real(0);
    for (int b = 0; b < Dim; ++b) {
        const Real share = kept ? axis[b] * axis[b] : axis[b];
        for (int c = 0; c < Dim; ++c) taken(c, b) = (share - Real(1)) * a(c, b);
        left += share * a(b, b);
    }
    for (int b = 0; b < Dim; ++b) taken(b, b) += (volume - Real(1)) * left * part[b];
    return taken;
}

}  // namespace moraine
