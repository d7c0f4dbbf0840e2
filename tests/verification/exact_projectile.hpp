#pragma once
// E6: free flight of an unstressed body, x = x0 + v0 t + g t^2 / 2.
//
// The scheme moves a particle by the velocity after the push. With the velocity given at t = 0 instead of
// -dt/2 it is therefore ahead by exactly g t dt / 2, which is no error of the transfer.

#include <array>
#include <cstddef>

namespace moraine::verification {

struct Projectile {
    std::array<double, 2> velocity;  ///< v0 [m/s]
    std::array<double, 2> gravity;   ///< [m/s2]

    double velocity_at(std::size_t a, double t) const { return velocity[a] + gravity[a] * t; }
    double path(std::size_t a, double t) const { return velocity[a] * t + 0.5 * gravity[a] * t * t; }
    double lead(std::size_t a, double t, double dt) const { return 0.5 * gravity[a] * t * dt; }
};

}  // namespace moraine::verification
