#pragma once
// Gravity over time: the scene's vector, times its table where it has one (core/data/time_table.hpp), less the
// acceleration of the base where that shakes.
//
// A scene that shakes is seen from its base: rho dv/dt = div sigma + rho (g - a), v relative to it. The grid, walls and
// structures go with the base, so nothing crosses a cell because the ground moves. A compliant base is seen from where
// its rock crops out, V = 2 v_up: the traction 2 rho c v_up - rho c v of Joyner and Chen (1975) on an absorbing end is
// -rho c (v - V) there, which is what that end does by itself (core/nodes/absorbing_ends.hpp). So both are one body
// force, exact in its impulse, on any engine.
//
// A step has one gravity, the mean over its length. The potential energy is by the gravity of the last step; where
// that changes from g to g', it jumps by -(g' - g) . sum m (x - domain.min): the work of who changes gravity
// (core/data/gravity_work.hpp), which history.csv has as gravity_work_J.

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/scene_spec.hpp"

namespace moraine {

inline Triple scaled_gravity(const Scene& scene, double factor) {
    return {factor * scene.gravity[0], factor * scene.gravity[1], factor * scene.gravity[2]};
}

/// Of shaking, over the table [-].
inline double motion_factor(const ShakingSpec& shaking) {
    return shaking.motion == BaseMotion::upgoing ? 2 : 1;
}

/// Acceleration of the base from `from` to `to`, from < to, of a table that begins at `begin` [m/s2].
inline double base_acceleration(const ShakingSpec& shaking, double begin, double from, double to) {
    if (shaking.table.empty() || to <= begin) return 0;
    const double a = from - begin, b = to - begin;
    const double mean = shaking.of_velocity ? (shaking.table.at(b) - shaking.table.at(a)) / (b - a)
                                            : shaking.table.mean(a < 0 ? 0 : a, b) * (a < 0 ? b / (b - a) : 1);
    return motion_factor(shaking) * mean;
}

/// Velocity of the base at time t [m/s].
inline double base_velocity(const ShakingSpec& shaking, double begin, double t) {
    if (shaking.table.empty() || t <= begin) return 0;
    const double velocity =
        shaking.of_velocity ? shaking.table.at(t - begin) : shaking.table.mean(0, t - begin) * (t - begin);
    return motion_factor(shaking) * velocity;
}

/// Gravity's main axis.
inline int up_axis(const Scene& scene) {
    std::size_t up = 0;
    for (std::size_t a = 1; a < static_cast<std::size_t>(scene.dimensions); ++a)
        if (std::fabs(scene.gravity[a]) > std::fabs(scene.gravity[up])) up = a;
    return static_cast<int>(up);
}

/// Pressure of still water at a height [Pa].
inline double still_water(const Scene& scene, double height) {
    const double g = std::fabs(scene.gravity[static_cast<std::size_t>(up_axis(scene))]);
    return scene.water.table ? scene.water.density * g * std::max(0.0, *scene.water.table - height) : 0;
}

/// Whether gravity of a step is not always the scene's.
inline bool gravity_changes(const Scene& scene) {
    return !scene.course.gravity.empty() || !scene.course.shaking.table.empty();
}

/// Whether it has a part along this axis at some time.
inline bool may_fall(const Scene& scene, std::size_t axis) {
    const ShakingSpec& shaking = scene.course.shaking;
    return scene.gravity[axis] != 0 || (!shaking.table.empty() && shaking.direction[axis] != 0);
}

/// At a time, of a base that stands still [m/s2].
inline Triple gravity_at(const Scene& scene, double t) {
    return scene.course.gravity.empty() ? scene.gravity : scaled_gravity(scene, scene.course.gravity.at(t));
}

/// Of a step from `from` to `to`; shaking: when it begins [m/s2].
inline Triple gravity_over(const Scene& scene, double from, double to, double shaking) {
    Triple g =
        scene.course.gravity.empty() ? scene.gravity : scaled_gravity(scene, scene.course.gravity.mean(from, to));
    if (scene.course.shaking.table.empty()) return g;
    const double a = base_acceleration(scene.course.shaking, shaking, from, to);
    for (std::size_t k = 0; k < 3; ++k) g[k] -= a * scene.course.shaking.direction[k];
    return g;
}

/// The largest of the run over the scene's [-].
inline double largest_gravity(const Scene& scene) {
    return scene.course.gravity.empty() ? 1 : scene.course.gravity.largest();
}

}  // namespace moraine
