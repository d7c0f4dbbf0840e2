#pragma once
// Elastic-perfectly plastic von Mises clay under undrained load, with rate effect and softening.
//
//   sqrt(J2) <= s_u(gd, xi)       matched to simple shear and plane strain: yields there at tau = s_u
//   radial return s <- s tau / sqrt(J2_trial), no plastic volume change
//   gd dt = 2 sqrt(J2(de)), dxi = 2 sqrt(J2(de_pl)): engineering shear strain in simple shear
//
// Strength: undrained_strength.hpp. J2 is compared with the square of the least strength first, so that
// an elastic step costs no square root, division or exponential.

#include <cmath>

#include "core/material/undrained_strength.hpp"

namespace moraine {

template <class Real>
struct VonMises {
    static constexpr const char* name = "von-mises";
    static constexpr int history = 1;
    static constexpr const char* history_names[] = {"plastic_shear_strain"};
    static constexpr bool uses_left_stretch = false;
    static constexpr bool flows = true;
    static constexpr const auto& parameters = undrained_parameters;
    static constexpr int over_depth[] = {0, 2};
    static const char* problem(const double* values) { return UndrainedStrength<double>::problem(values); }

    Hypoelastic<Real> elastic;
    UndrainedStrength<Real> strength;

    explicit VonMises(const double* values) : elastic(values[0], values[1]), strength(values) {}

    /// The same of its own moduli and su (over_depth.hpp).
    MORAINE_HD VonMises of(const OwnProperties<Real>& own) const {
        VonMises law = *this;
        if (own.has(0)) law.elastic = elastic.times(own[0]);
        if (own.has(1)) law.strength = strength.of(own[1]);
        return law;
    }

    template <int Dim>
    MORAINE_HD void update(const StrainIncrement<Real, Dim>& step, PointState<Real, Dim>& state) const {
        state.stress = elastic.trial(step, state.stress);
        after_trial(step, state);
    }

    template <int Dim>
    MORAINE_HD void after_trial(const StrainIncrement<Real, Dim>& step, PointState<Real, Dim>& state) const {
        using std::sqrt;
        const Invariants<Real> trial = invariants(state.stress);
        if (trial.j2 <= strength.lowest * strength.lowest) return;

        const Real rate = rate_in(step);
        const Real tau = sqrt(trial.j2);
        Real& xi = state.history[0];
        if (tau <= strength.at(rate, xi)) return;
        const Real yield = strength.returned(tau, elastic.shear, rate, xi);
        scale_deviator(state.stress, trial.mean, trial.mean, yield / tau);
    }

    /// r of the step's total strain [-].
    template <int Dim>
    MORAINE_HD Real rate_in(const StrainIncrement<Real, Dim>& step) const {
        using std::sqrt;
        if (!strength.depends_on_rate) return Real(1);
        return strength.rate_factor(Real(2) * sqrt(invariants(step.strain).j2) / step.dt);
    }

    template <int Dim>
    MORAINE_HD Real wave_modulus(const PointState<Real, Dim>&) const {
        return elastic.wave_modulus();
    }

    template <int Dim>
    MORAINE_HD Real strain_energy(const PointState<Real, Dim>& state) const {
        return elastic.energy(state.stress);
    }
};

}  // namespace moraine
