#pragma once
// Undrained shear strength with rate effect and softening: Einav and Randolph (2005), doi
// 10.1002/nme.1290; Zhu and Randolph (2011). Shared by von_mises.hpp and tresca.hpp.
//
//   s_u(gd, xi) = r(gd) [d + (1 - d) exp(-3 xi / xi95)] su,   d = 1 / sensitivity
//   r = 1 + rate_log log10(max(gd, gd_ref) / gd_ref)   or   r = 1 + rate_power (gd / gd_ref)^rate_exponent
//   gd  shear strain rate of the step's total strain increment [1/s]
//   xi  accumulated plastic shear strain (engineering: in simple shear, plastic gamma) [-]
//
// Return to the surface: tau = tau_trial - G dxi = s_u(gd, xi + dxi). The difference of both sides is
// concave in dxi, so Newton from the residual strength's side falls monotonically on the one root, also
// when softening is steeper than G: no bracket is needed.

#include <cmath>
#include <limits>

#include "core/material/hypoelastic.hpp"

namespace moraine {

inline constexpr Parameter undrained_parameters[] = {
    young_parameter,
    poisson_parameter,
    {"su", "Pa", required, 0, unbounded, true, "undrained shear strength, undisturbed and at the reference rate"},
    {"rate_log", "-", 0, 0, unbounded, false, "gain of strength per tenfold shear strain rate"},
    {"rate_reference", "1/s", 0, 0, unbounded, false, "reference shear strain rate; needed by either rate effect"},
    {"rate_power", "-", 0, 0, unbounded, false, "gain of strength at the reference rate, power law"},
    {"rate_exponent", "-", 1, 0, unbounded, true, "exponent of the power law"},
    {"sensitivity", "-", 1, 1, unbounded, false, "undisturbed over fully remoulded strength"},
    {"xi95", "-", 10, 0, unbounded, true, "plastic shear strain at 95 % of the remoulding"}};

template <class Real>
struct UndrainedStrength {
    static constexpr int newton_limit = 20;
    static constexpr Real tolerance = Real(2) * std::numeric_limits<Real>::epsilon();

    Real su;             ///< at r = 1, xi = 0 [Pa]
    Real lowest;         ///< fully remoulded: no yield below it at any rate [Pa]
    Real rate_log;       ///< [-]
    Real rate_power;     ///< [-]
    Real rate_exponent;  ///< [-]
    Real rate_inverse;   ///< 1 / gd_ref [s]
    Real remoulded;      ///< d [-]
    Real decay;          ///< 3 / xi95 [-]
    Real sensitivity;    ///< 1 / d [-]
    bool depends_on_rate;
    bool softens;

    explicit UndrainedStrength(const double* values)
        : su(Real(values[2])),
          lowest(Real(values[2] / values[7])),
          rate_log(Real(values[3])),
          rate_power(Real(values[5])),
          rate_exponent(Real(values[6])),
          rate_inverse(Real(values[4] > 0 ? 1 / values[4] : 0)),
          remoulded(Real(1 / values[7])),
          decay(Real(3 / values[8])),
          sensitivity(Real(values[7])),
          depends_on_rate(values[3] > 0 || values[5] > 0),
          softens(values[7] > 1) {}

    static const char* problem(const double* values) {
        if (values[3] > 0 && values[5] > 0)
            return "rate_log and rate_power are both given (one rate law at a time). Remove one of them?";
        if ((values[3] > 0 || values[5] > 0) && !(values[4] > 0))
            return "rate_reference is missing (the rate effect needs it). Give rate_reference in 1/s?";
        return nullptr;
    }

    /// The same of another su [Pa].
    MORAINE_HD UndrainedStrength of(Real other) const {
        UndrainedStrength strength = *this;
        strength.su = other;
        strength.lowest = softens ? other / sensitivity : other;
        return strength;
    }

    /// r(gd), at least 1; shear_rate in 1/s.
    MORAINE_HD Real rate_factor(Real shear_rate) const {
        using std::log10;
        using std::pow;
        const Real ratio = shear_rate * rate_inverse;
        if (rate_log > Real(0)) return ratio > Real(1) ? Real(1) + rate_log * log10(ratio) : Real(1);
        return ratio > Real(0) ? Real(1) + rate_power * pow(ratio, rate_exponent) : Real(1);
    }

    /// s_u [Pa] for a rate factor r and plastic shear strain xi.
    MORAINE_HD Real at(Real rate, Real xi) const {
        using std::exp;
        const Real fresh = rate * su;
        if (!softens) return fresh;
        return fresh * (remoulded + (Real(1) - remoulded) * exp(-decay * xi));
    }

    /// tau on the yield surface for an elastic trial beyond it [Pa]; xi advances.
    MORAINE_HD Real returned(Real trial, Real shear_modulus, Real rate, Real& xi) const {
        const Real residual = rate * lowest;
        if (!softens) {
            xi += (trial - rate * su) / shear_modulus;
            return rate * su;
        }
        const Real most = (trial - residual) / shear_modulus;
        Real increment = most;
        for (int i = 0; i < newton_limit; ++i) {
            const Real strength = at(rate, xi + increment);
            const Real slope = shear_modulus - decay * (strength - residual);
            if (!(slope > Real(0))) break;
            const Real change = (trial - shear_modulus * increment - strength) / slope;
            increment += change;
            if (-change <= tolerance * most) break;
        }
        xi += increment > Real(0) ? increment : Real(0);
        return at(rate, xi);
    }
};

}  // namespace moraine
