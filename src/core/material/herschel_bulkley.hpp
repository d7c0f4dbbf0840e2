#pragma once
// Elastic-viscoplastic Herschel-Bulkley slurry: elastic below the yield stress (it comes to rest), and above
//
//   tau = yield_stress + K gd_pl^n,  tau = sqrt(J2),  gd_pl engineering plastic shear rate [1/s]
//
// Implicit: with the overstress A = tau_trial - yield_stress, q = tau - yield_stress and
// G gd_pl dt = A - q, one equation q = K ((A - q) / (G dt))^n. Closed for n = 1 (Bingham, Newtonian);
// else z + (s z)^m = 1, m = max(n, 1/n), in whichever of q/A and 1 - q/A makes it convex: Newton from
// above falls monotonically on the root and s z <= 1, so nothing overflows. No regularised viscosity:
// that creeps for ever. The implicit return is stable at the elastic time step whatever K.

#include <cmath>
#include <limits>

#include "core/material/hypoelastic.hpp"

namespace moraine {

inline constexpr Parameter yield_stress_parameter = {
    "yield_stress", "Pa", required, 0, unbounded, false, "shear stress below which it is elastic"};

template <class Real>
struct HerschelBulkley {
    static constexpr const char* name = "herschel-bulkley";
    static constexpr int history = 0;
    static constexpr bool uses_left_stretch = false;
    static constexpr bool is_fluid = true;
    static constexpr Parameter parameters[] = {
        young_parameter,
        poisson_parameter,
        {"consistency", "Pa s^n", required, 0, unbounded, false, "K of tau = yield_stress + K rate^n"},
        yield_stress_parameter,
        {"exponent", "-", 1, 0, 10, true, "n of tau = yield_stress + K rate^n"}};
    static const char* problem(const double*) { return nullptr; }

    static constexpr int newton_limit = 20;
    static constexpr Real tolerance = std::numeric_limits<Real>::epsilon();

    Hypoelastic<Real> elastic;
    Real consistency;   ///< K [Pa s^n]
    Real yield_stress;  ///< [Pa]
    Real exponent;      ///< n [-]
    Real inverse;       ///< 1 / n [-]

    explicit HerschelBulkley(const double* values)
        : elastic(values[0], values[1]),
          consistency(Real(values[2])),
          yield_stress(Real(values[3])),
          exponent(Real(values[4])),
          inverse(Real(1 / values[4])) {}

    template <int Dim>
    MORAINE_HD void update(const StrainIncrement<Real, Dim>& step, PointState<Real, Dim>& state) const {
        state.stress = elastic.trial(step, state.stress);
        after_trial(step, state);
    }

    template <int Dim>
    MORAINE_HD void after_trial(const StrainIncrement<Real, Dim>& step, PointState<Real, Dim>& state) const {
        using std::sqrt;
        const Invariants<Real> trial = invariants(state.stress);
        if (trial.j2 <= yield_stress * yield_stress) return;
        const Real tau = sqrt(trial.j2);
        const Real over = tau - yield_stress;
        if (!(over > Real(0))) return;  // a root that rounds down to the yield stress
        const Real remains = yield_stress + over * viscous_share(over, step.dt);
        scale_deviator(state.stress, trial.mean, trial.mean, remains / tau);
    }

    /// q / A: the part of the overstress A [Pa] that viscosity still carries at the end of the step.
    MORAINE_HD Real viscous_share(Real over, Real dt) const {
        using std::pow;
        const Real elastic_rate = elastic.shear * dt;  // G dt [Pa s]
        if (exponent == Real(1)) return consistency / (consistency + elastic_rate);
        if (!(consistency > Real(0))) return Real(0);
        if (exponent < Real(1)) {
            const Real s = pow(elastic_rate / over, exponent) * (over / consistency);
            return root(s, inverse);
        }
        const Real s = pow(consistency / over, inverse) * (over / elastic_rate);
        return pow(s * root(s, exponent), exponent);  // is 1 - root, without cancellation
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
    /// z in [0, 1] with z + (s z)^m = 1, for m >= 1.
    static MORAINE_HD Real root(Real s, Real m) {
        using std::pow;
        Real z = s > Real(1) ? Real(1) / s : Real(1);
        for (int i = 0; i < newton_limit; ++i) {
            const Real power = pow(s * z, m);
            const Real fall = z * (z + power - Real(1)) / (z + m * power);
            z -= fall;
            if (fall <= tolerance * z) break;
        }
        return z;
    }
};

}  // namespace moraine
