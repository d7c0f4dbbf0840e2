#pragma once
// R9: a uniform film that flows steadily down an incline, no slip at the base, free surface.
//
//   tau(y) = rho g sin(theta) (H - y) = tau_y + K (du/dy)^n where it is above tau_y, Y = H - tau_y/(rho g sin(theta))
//   u(y) = n/(n+1) (rho g sin(theta)/K)^(1/n) [Y^((n+1)/n) - (Y - y)_+^((n+1)/n)]
//
// Newton: tau_y = 0, n = 1; Bingham: n = 1; above Y the film rides as a plug.

#include <algorithm>
#include <cmath>

namespace moraine::verification {

struct Film {
    double depth = 1;         ///< H [m]
    double density = 1000;    ///< [kg/m3]
    double pull = 8;          ///< g sin(theta) [m/s2]
    double press = 6;         ///< g cos(theta) [m/s2]
    double consistency = 0;   ///< K [Pa s^n]
    double yield_stress = 0;  ///< [Pa]
    double exponent = 1;      ///< n [-]

    double shear_stress(double y) const { return density * pull * (depth - y); }
    double plug() const { return std::max(0.0, depth - yield_stress / (density * pull)); }
    double velocity(double y) const {
        const double m = (exponent + 1) / exponent;
        const double below = std::max(0.0, plug() - y);
        return std::pow(density * pull / consistency, 1 / exponent) * (std::pow(plug(), m) - std::pow(below, m)) / m;
    }
    double surface_velocity() const { return velocity(depth); }
};

}  // namespace moraine::verification
