#pragma once
// How long an interval of rest is (simulation/rest_watch.hpp) where a scene does not say: the time in which a particle
// falls two cells, T = 2 (h / |g|)^(1/2). With 0.05 cells in it, what rests is slower than a fortieth of (g h)^(1/2).
// It follows the cells, not time.end: runouts that are asked to go on for longer end at the same time.

#include <cmath>

#include "core/scene_spec.hpp"

namespace moraine {

/// [s]; 0: there is no gravity, and the scene says nothing.
inline double rest_interval(const Scene& scene) {
    const double g = std::hypot(scene.gravity[0], scene.gravity[1], scene.gravity[2]);
    if (scene.rest.interval > 0) return scene.rest.interval;
    return g > 0 ? 2 * std::sqrt(scene.cell / g) : 0;
}

}  // namespace moraine
