#pragma once
// E4: the generalized vortex of Kamojjala, Brannon et al. (2015), plane strain: a ring 0.75 < R < 1.25 of a neo-Hookean
// body is turned to and fro, most in its middle, and shears by up to 6.2 A.
//
//   x = Q(a) X,   a = g(t) h(R),   g = A sin(pi t / T),   h = 1 - 32 (R - 1)^2 + 256 (R - 1)^4, 0 outside the ring
//   b_r = -R (g' h)^2 + (mu/rho0) R (g h_R)^2,   b_t = R g'' h - (mu/rho0) (3 g h_R + R g h_RR)
//   in the directions of the angle Theta + a;  J = 1
//
// The sign of R (g' h)^2 is that of Uintah's form; two published codes have it wrong in one term.

#include <array>
#include <cmath>
#include <numbers>

namespace moraine::verification {

struct Vortex {
    double amplitude = 1.0 / 3;  ///< A [rad]
    double young = 1000;         ///< E [Pa]
    double poisson = 0.3;
    double density = 1000;  ///< rho0 [kg/m3]
    double end = 1;         ///< T [s]

    using Point = std::array<double, 2>;

    double mu() const { return young / (2 * (1 + poisson)); }
    static double radius(const Point& X) { return std::hypot(X[0], X[1]); }
    static bool in_ring(const Point& X) { return std::fabs(radius(X) - 1) < 0.25; }

    /// h and its derivatives.
    static std::array<double, 3> profile(double R) {
        const double d = R - 1;
        if (std::fabs(d) >= 0.25) return {0, 0, 0};
        return {1 - 32 * d * d + 256 * d * d * d * d, -64 * d + 1024 * d * d * d, -64 + 3072 * d * d};
    }
    /// g and its derivatives.
    std::array<double, 3> motion(double t) const {
        const double w = std::numbers::pi / end;
        return {amplitude * std::sin(w * t), amplitude * w * std::cos(w * t), -amplitude * w * w * std::sin(w * t)};
    }
    Point place(const Point& X, double t) const {
        const double a = motion(t)[0] * profile(radius(X))[0], c = std::cos(a), s = std::sin(a);
        return {c * X[0] - s * X[1], s * X[0] + c * X[1]};
    }
    /// Angular velocity at t = 0 and its slope along R [1/s, 1/(m s)].
    Point spin(const Point& X) const {
        const std::array<double, 3> h = profile(radius(X));
        return {motion(0)[1] * h[0], motion(0)[1] * h[1]};
    }
    Point body_force(const Point& X, double t) const {
        const double R = radius(X), stiff = mu() / density;
        const std::array<double, 3> h = profile(R), g = motion(t);
        if (h[0] == 0) return {0, 0};
        const double along = -R * std::pow(g[1] * h[0], 2) + stiff * R * std::pow(g[0] * h[1], 2);
        const double across = R * g[2] * h[0] - stiff * (3 * g[0] * h[1] + R * g[0] * h[2]);
        const double angle = std::atan2(X[1], X[0]) + g[0] * h[0], c = std::cos(angle), s = std::sin(angle);
        return {along * c - across * s, along * s + across * c};
    }
};

}  // namespace moraine::verification
