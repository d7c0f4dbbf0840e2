#pragma once
// Isotropic hypoelasticity: the elastic part of every law that stores Cauchy stress only.
//
//   sigma <- Q sigma Qᵀ + lambda tr(de) I + 2 G de            (Jaumann rate, Hughes-Winget increment)
//   mean = tr sigma / 3 (tension positive), s = sigma - mean I, J2 = s:s / 2; simple shear: J2 = tau^2
//   energy = mean^2 / (2 K) + J2 / (2 G) per current volume
//
// Not derived from a potential: a closed cycle of large elastic strain leaves a residual stress, which
// is why laws that stay elastic at large strain use neo_hookean.hpp.

#include "core/material/own_properties.hpp"
#include "core/material/point.hpp"

namespace moraine {

inline constexpr Parameter young_parameter = {"young", "Pa", required, 0, unbounded, true, "Young's modulus"};
inline constexpr Parameter poisson_parameter = {"poisson", "-", required, -1, 0.5, true, "Poisson's ratio"};

/// Mean and second deviatoric invariant of a stress (or strain).
template <class Real>
struct Invariants {
    Real mean;
    Real j2;
};

template <class Real, int Dim>
MORAINE_HD Invariants<Real> invariants(const Sym<Real, Dim>& s) {
    Invariants<Real> v;
    v.mean = s.trace() * Real(1.0 / 3.0);
    const Real x = s[0] - v.mean, y = s[1] - v.mean, z = s[2] - v.mean;
    v.j2 = Real(0.5) * (x * x + y * y + z * z);
    for (int k = 3; k < Sym<Real, Dim>::size; ++k) v.j2 += s[k] * s[k];
    return v;
}

/// Replaces `from` + s by `to` + factor s, s the deviator.
template <class Real, int Dim>
MORAINE_HD void scale_deviator(Sym<Real, Dim>& stress, Real from, Real to, Real factor) {
    for (int k = 0; k < 3; ++k) stress[k] = to + factor * (stress[k] - from);
    for (int k = 3; k < Sym<Real, Dim>::size; ++k) stress[k] *= factor;
}

template <class Real>
struct Hypoelastic {
    Real lambda;  ///< first Lamé parameter [Pa]
    Real shear;   ///< G                    [Pa]
    Real bulk;    ///< K                    [Pa]

    Hypoelastic(double young, double poisson)
        : lambda(Real(young * poisson / ((1 + poisson) * (1 - 2 * poisson)))),
          shear(Real(young / (2 * (1 + poisson)))),
          bulk(Real(young / (3 * (1 - 2 * poisson)))) {}

    /// All moduli so many times as large.
    MORAINE_HD Hypoelastic times(Real factor) const {
        Hypoelastic other = *this;
        other.lambda *= factor, other.shear *= factor, other.bulk *= factor;
        return other;
    }

    /// The stress at the end of the step if nothing yields [Pa]. Number: Real, or one of several particles (lanes.hpp).
    template <class Number, int Dim>
    MORAINE_HD Sym<Number, Dim> trial(const StrainIncrement<Number, Dim>& step, const Sym<Number, Dim>& stress) const {
        Sym<Number, Dim> t = rotated(stress, step.rotation);
        const Number volumetric = Number(lambda) * step.strain.trace();
        const Number twice = Number(Real(2) * shear);
        for (int k = 0; k < 3; ++k) t[k] += volumetric;
        for (int k = 0; k < Sym<Real, Dim>::size; ++k) t[k] += twice * step.strain[k];
        return t;
    }

    /// K + 4 G / 3 [Pa].
    MORAINE_HD Real wave_modulus() const { return bulk + shear * Real(4.0 / 3.0); }

    /// Stored elastic energy per current volume [J/m3].
    template <int Dim>
    MORAINE_HD Real energy(const Sym<Real, Dim>& stress) const {
        const Invariants<Real> v = invariants(stress);
        return Real(0.5) * (v.mean * v.mean / bulk + v.j2 / shear);
    }
};

}  // namespace moraine
