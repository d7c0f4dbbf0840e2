#pragma once
// Dense granular flow, mu(I): elastic below yield, and above it friction that grows with the rate of shear
//
//   tau = mu(I) p,  mu(I) = mu_s + (mu_2 - mu_s) / (1 + I0 / I),  I = gd_pl d / sqrt(p / rho_grain)
//   tau = sqrt(J2), p = -mean, gd_pl engineering plastic shear rate [1/s]; no dilation, no cohesion
//
// of Jop, Forterre and Pouliquen (2006). Implicit: with B = tau_trial - mu_s p, z = G gd_pl dt / B and
// q = d sqrt(rho_grain) / (I0 G dt) one quadratic, q B z^2 + (sqrt p + q ((mu_2 - mu_s) p - B)) z = sqrt p, whose
// root lies in [0, 1]; nothing in it overflows as p goes to 0. It is stable at the elastic time step. In tension the
// grains fly apart (gap.hpp). As a continuum mu(I) is ill-posed at very small and very large I (Barker et al. 2015):
// here elasticity and the grid bound it.

#include <cmath>

#include "core/material/gap.hpp"
#include "core/material/hypoelastic.hpp"

namespace moraine {

template <class Real>
struct MuI {
    static constexpr const char* name = "mu-i";
    static constexpr int history = 2;
    static constexpr const char* history_names[] = {"plastic_shear_strain", "gap"};
    static constexpr bool uses_left_stretch = false;
    static constexpr Parameter parameters[] = {
        young_parameter,
        poisson_parameter,
        {"static_friction", "-", required, 0, 10, true,
         "Friction mu_s: sqrt(J2) over pressure at which it begins to flow"},
        {"limit_friction", "-", required, 0, 10, true,
         "Friction mu_2: the same in very fast flow, at least static_friction"},
        {"inertial_number", "-", 0.279, 0, unbounded, true, "I0, at which friction is half way from mu_s to mu_2"},
        {"grain_diameter", "m", required, 0, unbounded, false, "d of I = rate d / sqrt(pressure / grain_density)"},
        {"grain_density", "kg/m3", required, 0, unbounded, true, "of the solid of the grains"}};

    Hypoelastic<Real> elastic;
    Real friction;  ///< mu_s [-]
    Real gain;      ///< mu_2 - mu_s [-]
    Real sluggish;  ///< d sqrt(rho_grain) / (I0 G) [s / sqrt(Pa)]

    explicit MuI(const double* values) : elastic(values[0], values[1]) {
        friction = Real(values[2]);
        gain = Real(values[3] - values[2]);
        const double shear = values[0] / (2 * (1 + values[1]));
        sluggish = Real(values[5] * std::sqrt(values[6]) / (values[4] * shear));
    }

    static const char* problem(const double* values) {
        if (values[3] < values[2])
            return "limit_friction is below static_friction (friction would fall with the rate). Exchange them?";
        return nullptr;
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
        const Real before = state.history[1];
        Real gap = before;
        const Real mean = close_gap(gap, trial.mean, elastic.bulk);
        const Real tau = sqrt(trial.j2);
        Real& xi = state.history[0];
        if (!(mean < Real(0))) {
            xi += tau / elastic.shear;
            gap += mean / elastic.bulk;
            scale_deviator(state.stress, trial.mean, Real(0), Real(0));
        } else if (tau + friction * mean > Real(0)) {
            const Real remains = shear_stress(tau, -mean, step.dt);
            xi += (tau - remains) / elastic.shear;
            scale_deviator(state.stress, trial.mean, mean, remains / tau);
        } else if (gap != before) {
            scale_deviator(state.stress, trial.mean, mean, Real(1));
        }
        if (gap != before) keep_grains(state, before, gap);
        state.history[1] = gap;
    }

    /// sqrt(J2) at the end of a step whose trial is tau > mu_s p, at the pressure p > 0 [Pa].
    MORAINE_HD Real shear_stress(Real tau, Real p, Real dt) const {
        using std::sqrt;
        const Real over = tau - friction * p, more = gain * p, root = sqrt(p), q = sluggish / dt;
        const Real a = q * over, b = root + q * (more - over);
        const Real s = sqrt(b * b + Real(4) * a * root);
        // Two forms of one root: neither takes the difference of like numbers.
        const Real qbz = b > Real(0) ? Real(2) * a * root / (b + s) : Real(0.5) * (s - b);
        return friction * p + more * (qbz / (root + qbz));
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
