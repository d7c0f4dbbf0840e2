#pragma once
// R9: a uniform film that flows steadily down an incline, no slip at the base, free surface.
//
//   tau(y) = rho g sin(theta) (H - y) = tau_y + K (du/dy)^n where it is above tau_y, Y = H - tau_y/(rho g sin(theta))
//   u(y) = n/(n+1) (rho g sin(theta)/K)^(1/n) [Y^((n+1)/n) - (Y - y)_+^((n+1)/n)]
//
// Newton: tau_y = 0, n = 1; Bingham: n = 1; above Y the film rides as a plug.
//
// Grains of mu(I) (Bagnold's profile): mu(I) = tan(theta) at every height, so I is one number and
//   u(y) = 2/3 I/d sqrt(phi g cos(theta)) [H^(3/2) - (H - y)^(3/2)],  phi: share of the volume that grains fill

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

struct BagnoldFilm {
    double depth = 0.05;                       ///< H [m]
    double diameter = 1e-3;                    ///< d [m]
    double grain_density = 2500;               ///< [kg/m3]
    double packing = 0.6;                      ///< phi [-]
    double slope = 24 * degree;                ///< theta
    double static_friction = tangent(20.9);    ///< mu_s [-], Jop, Forterre and Pouliquen (2005)
    double limit_friction = tangent(32.76);    ///< mu_2 [-]
    double inertial_number = 0.279;            ///< I0 [-]
    double density = packing * grain_density;  ///< [kg/m3]
    double pull = 9.81 * std::sin(slope);      ///< g sin(theta) [m/s2]
    double press = 9.81 * std::cos(slope);     ///< g cos(theta) [m/s2]

    double flowing() const {  ///< I
        const double mu = std::tan(slope);
        return inertial_number * (mu - static_friction) / (limit_friction - mu);
    }
    double shear_stress(double y) const { return density * pull * (depth - y); }
    double velocity(double y) const {
        const double above = std::max(0.0, depth - y);
        return 2.0 / 3 * flowing() / diameter * std::sqrt(packing * press) *
               (std::pow(depth, 1.5) - std::pow(above, 1.5));
    }
    double surface_velocity() const { return velocity(depth); }

  private:
    static constexpr double degree = 0.017453292519943295;
    static double tangent(double degrees) { return std::tan(degrees * degree); }
};

}  // namespace moraine::verification
