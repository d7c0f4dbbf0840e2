#pragma once
// E3: manufactured displacement along the axes of a neo-Hookean body (Wallstedt and Guilkey 2008),
//
//   u_i = A sin(pi X_i) sin(c pi t + phi_i),   c = sqrt(E / rho0),   phi = (0, pi)
//   F_ii = 1 + A pi cos(pi X_i) sin(c pi t + phi_i),   P = mu (F - F^-T) + lambda ln J F^-T
//   b_i = (pi^2 u_i / rho0) [lambda (1 - ln J) / F_ii^2 + mu (1 + 1 / F_ii^2) - E]
//
// u = 0 on the faces of the unit square (free slip) and the whole repeats over [0, 2]. One period is 2/c.

#include <array>
#include <cmath>
#include <numbers>

namespace moraine::verification {

struct Manufactured {
    double amplitude;       ///< A [m]
    double poisson;         ///< nu
    double young = 1e7;     ///< E [Pa]
    double density = 1000;  ///< rho0 [kg/m3]
    int axes = 2;           ///< that move: 1 or 2

    static constexpr double k = std::numbers::pi;  ///< wave number [1/m]

    double speed() const { return std::sqrt(young / density); }
    double period() const { return 2 / speed(); }
    double lambda() const { return young * poisson / ((1 + poisson) * (1 - 2 * poisson)); }
    double mu() const { return young / (2 * (1 + poisson)); }
    double phase(int i, double t) const { return k * (speed() * t + i); }

    double displacement(int i, double X, double t) const {
        return i >= axes ? 0 : amplitude * std::sin(k * X) * std::sin(phase(i, t));
    }
    double velocity(int i, double X, double t) const {
        return i >= axes ? 0 : amplitude * std::sin(k * X) * k * speed() * std::cos(phase(i, t));
    }
    /// du_i'/dX_i at time t, the rate of F_ii [1/s].
    double stretch_rate(int i, double X, double t) const {
        return i >= axes ? 0 : amplitude * k * std::cos(k * X) * k * speed() * std::cos(phase(i, t));
    }
    double stretch(int i, double X, double t) const {
        return i >= axes ? 1 : 1 + amplitude * k * std::cos(k * X) * std::sin(phase(i, t));
    }
    /// Cauchy stress sigma_ii.
    double stress(int i, const std::array<double, 2>& X, double t) const {
        const double F = stretch(i, X[static_cast<std::size_t>(i)], t);
        const double J = stretch(0, X[0], t) * stretch(1, X[1], t);
        return (mu() * (F * F - 1) + lambda() * std::log(J)) / J;
    }
    double body_force(int i, const std::array<double, 2>& X, double t) const {
        const double x = X[static_cast<std::size_t>(i)];
        const double F2 = std::pow(stretch(i, x, t), 2);
        const double ln_J = std::log(stretch(0, X[0], t) * stretch(1, X[1], t));
        return k * k * displacement(i, x, t) / density * (lambda() * (1 - ln_J) / F2 + mu() * (1 + 1 / F2) - young);
    }
};

}  // namespace moraine::verification
