#pragma once
// E2: an elastic column that settles under its own weight, sides on rollers, base fixed, nu = 0. Exact at
// finite strain: the area does not change, so the Cauchy stress is the weight above,
//
//   sigma(Y) = -rho0 g (l0 - Y) = -M s,   M = E
//   linear-elastic (sigma = M ln lambda):          lambda = exp(-s)
//   neo-hookean (lambda sigma = M (lambda^2 - 1)/2): lambda = -s + sqrt(s^2 + 1)
//
// Y: height at the start. Place y(Y): integral of lambda, in closed form for both.

#include <cmath>

namespace moraine::verification {

struct Column {
    double height = 50;   ///< l0 [m]
    double young = 1e6;   ///< [Pa]
    double density = 80;  ///< rho0 [kg/m3]
    double gravity = 10;  ///< [m/s2]

    double base_pressure() const { return density * gravity * height; }
    double stress(double Y) const { return -density * gravity * (height - Y); }
    double wave_speed() const { return std::sqrt(young / density); }

    /// Of linear-elastic: (exp(-k (l0 - Y)) - exp(-k l0)) / k, k = rho0 g / M.
    double place(double Y) const {
        const double k = density * gravity / young;
        return (std::exp(-k * (height - Y)) - std::exp(-k * height)) / k;
    }
    /// Of neo-hookean: the integral of sqrt(s^2 + 1) - s over Y.
    double place_neo_hookean(double Y) const {
        const double k = density * gravity / young;
        return (primitive(k * height) - primitive(k * (height - Y))) / k;
    }

  private:
    static double primitive(double s) { return 0.5 * (s * std::sqrt(s * s + 1) + std::asinh(s) - s * s); }
};

}  // namespace moraine::verification
