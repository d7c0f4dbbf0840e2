#pragma once
// What a scene says of sleep (core/sleep/sleep.hpp): the interval of its checks and their thresholds.

#include <cmath>

#include "core/scene_spec.hpp"
#include "core/sleep/sleep.hpp"

namespace moraine {

/// Between sleep checks [s]; 0: there is no gravity, and the scene says nothing.
inline double sleep_interval(const Scene& scene) {
    const double g = std::hypot(scene.gravity[0], scene.gravity[1], scene.gravity[2]);
    if (scene.sleep.interval > 0) return scene.sleep.interval;
    return g > 0 ? std::sqrt(scene.cell / g) : 0;
}

/// Whether a record of block loads says who would sleep (records/sleep_forecast.hpp).
inline bool forecasts_sleep(const Scene& scene) {
    return scene.output.sleep_forecast && !scene.sleep.on;
}

/// The largest speed of a structure whose motion is prescribed [m/s]; 0: it stands, or is free.
inline double prescribed_speed(const MotionSpec& m) {
    constexpr double pi = 3.14159265358979;
    const auto magnitude = [](const Triple& v) { return std::hypot(v[0], v[1], v[2]); };
    switch (m.kind) {
        case StructureMotion::velocity:
            return magnitude(m.velocity);
        case StructureMotion::sinusoid:
            return 2 * pi / m.period * magnitude(m.amplitude);
        case StructureMotion::table:
            return magnitude(m.velocity) * m.factor.largest();
        default:
            return 0;
    }
}

/// eps [cells]: the scene's, but so much less that every structure moves twenty times as fast as v_w. At a tenth loads
/// on slow pipes were 1.2 % off, at a half 6 % (docs/sleep.md).
inline double sleep_displacement(const Scene& scene) {
    constexpr double times = 20;
    double eps = scene.sleep.displacement;
    for (const StructureSpec& s : scene.structures)
        if (const double v = prescribed_speed(s.motion); v > 0)
            eps = std::fmin(eps, v * sleep_interval(scene) / (times * scene.sleep.wake * scene.cell));
    return eps;
}

inline SleepRule sleep_rule(const Scene& scene) {
    const SleepSpec& s = scene.sleep;
    const double g = std::hypot(scene.gravity[0], scene.gravity[1], scene.gravity[2]);
    const double eps = sleep_displacement(scene), interval = sleep_interval(scene);
    return {eps, s.stress * g * 4 * scene.cell, s.wake * eps * scene.cell / interval, s.wake, interval};
}

}  // namespace moraine
