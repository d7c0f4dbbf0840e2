#pragma once
// E1: longitudinal vibration of an elastic bar in one mode, small strain, no lateral strain (nu = 0).
//
//   v = v0 sin(b x) cos(w t),   u = (v0 / w) sin(b x) sin(w t),   w = b c,   c = sqrt(E / rho)
//
// Fixed at 0 and free at L: b = pi / (2 L). Periodic over 4 L: the same standing wave, whole. A uniform
// drift may be added to the periodic bar. Energy of the mode: rho v0^2 / 2 times half the volume.

#include <cmath>
#include <numbers>

namespace moraine::verification {

struct Bar {
    double length = 25;  ///< L [m]
    double young = 100;  ///< [Pa]
    double density = 1;  ///< [kg/m3]
    double speed = 0.1;  ///< v0 [m/s]

    double wave_speed() const { return std::sqrt(young / density); }
    double wave_number() const { return std::numbers::pi / (2 * length); }
    double frequency() const { return wave_number() * wave_speed(); }
    double period() const { return 2 * std::numbers::pi / frequency(); }
    double shape(double x) const { return std::sin(wave_number() * x); }
    double velocity(double x, double t) const { return speed * shape(x) * std::cos(frequency() * t); }
    double stress(double x, double t) const {
        return young * speed / wave_speed() * std::cos(wave_number() * x) * std::sin(frequency() * t);
    }
    double energy(double volume) const { return 0.25 * density * speed * speed * volume; }
};

}  // namespace moraine::verification
