#pragma once
// Gravity over time: the scene's vector, times its table where it has one (core/data/time_table.hpp).
//
// A step has one gravity, the mean over its length. The potential energy is by the gravity of the last step; where
// that changes from g to g', it jumps by -(g' - g) . sum m (x - domain.min): the work of who changes gravity
// (core/data/gravity_work.hpp), which history.csv has as gravity_work_J.

#include "core/scene_spec.hpp"

namespace moraine {

inline Triple scaled_gravity(const Scene& scene, double factor) {
    return {factor * scene.gravity[0], factor * scene.gravity[1], factor * scene.gravity[2]};
}

/// At a time [m/s2].
inline Triple gravity_at(const Scene& scene, double t) {
    return scene.course.gravity.empty() ? scene.gravity : scaled_gravity(scene, scene.course.gravity.at(t));
}

/// Of a step from `from` to `to` [m/s2].
inline Triple gravity_over(const Scene& scene, double from, double to) {
    return scene.course.gravity.empty() ? scene.gravity : scaled_gravity(scene, scene.course.gravity.mean(from, to));
}

/// The largest of the run over the scene's [-].
inline double largest_gravity(const Scene& scene) {
    return scene.course.gravity.empty() ? 1 : scene.course.gravity.largest();
}

}  // namespace moraine
