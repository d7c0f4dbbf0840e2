#pragma once
// Drucker-Prager soil: elastic-perfectly plastic, non-associated, cut in tension at the apex.
//
//   sqrt(J2) + eta mean <= k cohesion   (tension positive);   flow  de_pl = dg (s / (2 sqrt(J2)) + etab I / 3)
//   dg = f / (G + K eta etab), engineering plastic shear strain; past the apex: s = 0, mean = k cohesion / eta
//
// Pulled past the apex grains fly apart: the volume so gained closes before there is pressure again (gap.hpp),
// and grains that are apart do not dilate.
//
// matching 0, plane strain: at collapse (de_zz elastic = 0) the same strength and dilation as Mohr-Coulomb,
//   etab = sin psi / sqrt(1 + sin^2 psi / 3),  eta = sin phi / D,  k = cos phi / D,
//   D = sqrt(1 - etab^2 / 3) + etab sin phi / 3
//   psi = 0: eta = sin phi; psi = phi: 3 tan phi / sqrt(9 + 12 tan^2 phi), de Souza Neto et al. (2008), 6.122.
// matching 1, compression cone: (eta, k) = 6 (sin phi, cos phi) / (sqrt(3) (3 - sin phi)), etab likewise of psi.

#include <cmath>
#include <limits>

#include "core/material/gap.hpp"
#include "core/material/hypoelastic.hpp"

namespace moraine {

template <class Real>
struct DruckerPrager {
    static constexpr const char* name = "drucker-prager";
    static constexpr int history = 2;
    static constexpr const char* history_names[] = {"plastic_shear_strain", "gap"};
    static constexpr bool uses_left_stretch = false;
    static constexpr Parameter parameters[] = {
        young_parameter,
        poisson_parameter,
        {"friction_angle", "deg", required, 0, 89, false, "Mohr-Coulomb friction angle"},
        {"dilation_angle", "deg", 0, 0, 89, false, "Mohr-Coulomb dilation angle, at most the friction angle"},
        {"cohesion", "Pa", 0, 0, unbounded, false, "Mohr-Coulomb cohesion"},
        {"matching", "-", 0, 0, 1, false, "0: as Mohr-Coulomb in plane strain; 1: in triaxial compression"}};

    static constexpr int over_depth[] = {0, 2, 4};
    static constexpr Real no_apex = std::numeric_limits<Real>::max();

    Hypoelastic<Real> elastic;
    Real friction;               ///< eta [-]
    Real dilation;               ///< etab [-]
    Real strength;               ///< k cohesion [Pa]
    Real apex;                   ///< mean stress at s = 0 [Pa]
    Real sine, cosine, divisor;  ///< sin phi, cos phi, cos phi / k [-]
    Real cohesion;               ///< [Pa]
    bool compression;            ///< matching 1

    explicit DruckerPrager(const double* values) : elastic(values[0], values[1]) {
        const double sin_phi = std::sin(values[2] * degree), cos_phi = std::cos(values[2] * degree);
        const double sin_psi = std::sin(values[3] * degree);
        double d, etab;
        if (values[5] > 0.5) {
            d = std::sqrt(3.0) * (3 - sin_phi) / 6;
            etab = 6 * sin_psi / (std::sqrt(3.0) * (3 - sin_psi));
        } else {
            etab = sin_psi / std::sqrt(1 + sin_psi * sin_psi / 3);
            d = std::sqrt(1 - etab * etab / 3) + etab * sin_phi / 3;
        }
        friction = Real(sin_phi / d);
        dilation = Real(etab);
        strength = Real(values[4] * cos_phi / d);
        apex = sin_phi > 0 ? Real(values[4] * cos_phi / sin_phi) : no_apex;
        cohesion = Real(values[4]), compression = values[5] > 0.5;
        sine = Real(sin_phi), cosine = Real(cos_phi), divisor = Real(d);
    }

    /// The same of its own moduli, friction angle and cohesion (over_depth.hpp).
    MORAINE_HD DruckerPrager of(const OwnProperties<Real>& own) const {
        DruckerPrager law = *this;
        if (own.has(0)) law.elastic = elastic.times(own[0]);
        if (own.has(1)) law.set_friction(own[1]);
        if (own.has(2)) law.cohesion = own[2];
        law.strength = law.cohesion * law.cosine / law.divisor;
        law.apex = law.sine > Real(0) ? law.cohesion * law.cosine / law.sine : no_apex;
        return law;
    }

    static const char* problem(const double* values) {
        if (values[3] > values[2])
            return "dilation_angle is above friction_angle (plastic flow would create energy). Exchange them?";
        if (!(values[2] > 0) && !(values[4] > 0))
            return "friction_angle and cohesion are both 0 (no strength at all). Give one of them?";
        if (values[5] != 0 && values[5] != 1)
            return "matching is neither 0 nor 1 (0 plane strain, 1 compression cone). Did you mean 0?";
        return nullptr;
    }

    template <int Dim>
    MORAINE_HD void update(const StrainIncrement<Real, Dim>& step, PointState<Real, Dim>& state) const {
        state.stress = elastic.trial(step, state.stress);
        after_trial(step, state);
    }

    template <int Dim>
    MORAINE_HD void after_trial(const StrainIncrement<Real, Dim>&, PointState<Real, Dim>& state) const {
        using std::sqrt;
        const Invariants<Real> trial = invariants(state.stress);
        const Real before = state.history[1];
        Real gap = before;
        const Real mean = close_gap(gap, trial.mean, elastic.bulk);
        const Real strength_left = strength - friction * mean;  // largest sqrt(J2) at this mean stress
        if (strength_left >= Real(0) && trial.j2 <= strength_left * strength_left) {
            if (gap != before) scale_deviator(state.stress, trial.mean, mean, Real(1));
        } else {
            flow(state, trial, mean, strength_left, gap);
        }
        if (gap != before) keep_grains(state, before, gap);
        state.history[1] = gap;
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
    static constexpr double degree = 0.017453292519943295;

    /// phi [deg].
    MORAINE_HD void set_friction(Real angle) {
        using std::cos;
        using std::sin;
        using std::sqrt;
        sine = sin(angle * Real(degree)), cosine = cos(angle * Real(degree));
        divisor = compression ? sqrt(Real(3)) * (Real(3) - sine) / Real(6)
                              : sqrt(Real(1) - dilation * dilation / Real(3)) + dilation * sine / Real(3);
        friction = sine / divisor;
    }

    /// Back to the cone, or to its apex, from the trial deviator and the mean stress `mean`.
    template <int Dim>
    MORAINE_HD void flow(PointState<Real, Dim>& state, const Invariants<Real>& trial, Real mean, Real strength_left,
                         Real& gap) const {
        using std::sqrt;
        const Real swell = gap > Real(0) ? Real(0) : elastic.bulk * dilation;
        const Real tau = sqrt(trial.j2);
        const Real shear_strain = (tau - strength_left) / (elastic.shear + swell * friction);
        const Real remains = tau - elastic.shear * shear_strain;
        Real& xi = state.history[0];
        if (remains > Real(0) && !(gap > Real(0) && mean >= apex)) {
            xi += shear_strain;
            scale_deviator(state.stress, trial.mean, mean - swell * shear_strain, remains / tau);
        } else {
            xi += tau / elastic.shear;
            if (mean > apex) gap += (mean - apex) / elastic.bulk;
            scale_deviator(state.stress, trial.mean, apex, Real(0));
        }
    }
};

}  // namespace moraine
