#pragma once
// Elastic-perfectly plastic Tresca clay under undrained load, with rate effect and softening.
//
//   (sigma1 - sigma3) / 2 <= s_u(gd, xi)
//   gd dt = d(eps1 - eps3), dxi = d(eps1 - eps3)_pl
//
// Associated flow, exact return in principal stresses: to the plane, sigma1 and sigma3 move by the same
// amount; where that would pass sigma2, to the corner (mean + 2/3, 2/3, -4/3 s_u, or its mirror). In each
// case dxi = (tau_trial - tau) / G, the scalar equation of undrained_strength.hpp. The inscribed circle
// J2 = s_u^2 is looked at first: most elastic steps need no principal values.

#include "core/material/spectrum.hpp"
#include "core/material/undrained_strength.hpp"

namespace moraine {

template <class Real>
struct Tresca {
    static constexpr const char* name = "tresca";
    static constexpr int history = 1;
    static constexpr const char* history_names[] = {"plastic_shear_strain"};
    static constexpr bool uses_left_stretch = false;
    static constexpr bool flows = true;
    static constexpr DeviceBlocks device_blocks{.averaged = 4};
    static constexpr DeviceBlocks device_blocks_over_depth{.averaged = 4, .double_fused = 2};
    static constexpr const auto& parameters = undrained_parameters;
    static constexpr int over_depth[] = {0, 2};
    static const char* problem(const double* values) { return UndrainedStrength<double>::problem(values); }

    Hypoelastic<Real> elastic;
    UndrainedStrength<Real> strength;

    explicit Tresca(const double* values) : elastic(values[0], values[1]), strength(values) {}

    /// The same of its own moduli and su (over_depth.hpp).
    MORAINE_HD Tresca of(const OwnProperties<Real>& own) const {
        Tresca law = *this;
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
        const Invariants<Real> trial = invariants(state.stress);
        if (trial.j2 <= strength.lowest * strength.lowest) return;

        const Spectrum<Real, Dim> principal(state.stress);
        const Ordered<Real> sigma(principal.value);
        const Real tau = Real(0.5) * (sigma.first - sigma.third);
        if (tau <= strength.lowest) return;
        const Real rate = rate_in(step);
        Real& xi = state.history[0];
        if (tau <= strength.at(rate, xi)) return;
        const Real yield = strength.returned(tau, elastic.shear, rate, xi);
        return_to(yield, trial.mean, sigma, principal, state.stress);
    }

    /// r of the step's total strain [-].
    template <int Dim>
    MORAINE_HD Real rate_in(const StrainIncrement<Real, Dim>& step) const {
        if (!strength.depends_on_rate) return Real(1);
        const Spectrum<Real, Dim> strain(step.strain);
        const Ordered<Real> eps(strain.value);
        return strength.rate_factor((eps.first - eps.third) / step.dt);
    }

    template <int Dim>
    MORAINE_HD Real wave_modulus(const PointState<Real, Dim>&) const {
        return elastic.wave_modulus();
    }

    template <int Dim>
    MORAINE_HD Real strain_energy(const PointState<Real, Dim>& state) const {
        return elastic.energy(state.stress);
    }

  private:
    template <int Dim>
    static MORAINE_HD void return_to(Real yield, Real mean, const Ordered<Real>& sigma,
                                     const Spectrum<Real, Dim>& principal, Sym<Real, Dim>& stress) {
        const Real excess = Real(0.5) * (sigma.first - sigma.third) - yield;
        Real first = sigma.first - excess;
        Real second = sigma.second;
        Real third = sigma.third + excess;
        const Real step = yield * Real(2.0 / 3.0);
        if (first < second) {
            first = second = mean + step;
            third = mean - Real(2) * step;
        } else if (third > second) {
            first = mean + Real(2) * step;
            second = third = mean - step;
        }
        // Equal principal values end in a corner and so take equal changes, whichever comes first here.
        Real change[3];
        for (int k = 0; k < 3; ++k) {
            const Real v = principal.value[k];
            change[k] = v == sigma.first ? first - v : (v == sigma.third ? third - v : second - v);
        }
        principal.add(stress, change);
    }
};

}  // namespace moraine
