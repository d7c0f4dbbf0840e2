#pragma once
// Prescribed motion of structures: displacement u(t) [m] in closed form.
//
//   velocity   v(t) = V (1 - cos(pi t / T)) / 2 until T = ramp, then V
//   sinusoid   u(t) = A sin(2 pi t / period)
//   table      v(t) = V f(t), f linear between its times and constant before and after them
//
// A step's velocity is (u(t + dt) - u(t)) / dt: the way is exact however the steps fall. What turns does so about one
// axis, by the same factor of time.

#include <cmath>
#include <numbers>

#include "core/scene_spec.hpp"

namespace moraine {

/// Integral of the table's factor from 0 to t [s].
inline double table_integral(const TimeTable& f, double t) {
    double sum = 0, from = 0, at_from = f.values.front();
    for (std::size_t k = 0; k < f.times.size() && from < t; ++k) {
        const double to = std::min(t, f.times[k]);
        if (to <= from) {  // the first time may be 0
            at_from = f.values[k];
            continue;
        }
        const double share = (to - from) / (f.times[k] - from);
        const double at_to = at_from + share * (f.values[k] - at_from);
        sum += 0.5 * (at_from + at_to) * (to - from);
        from = to, at_from = at_to;
    }
    return sum + (t > from ? (t - from) * f.values.back() : 0);
}

/// Displacement along the velocity over its magnitude [s], or of the amplitude over its own [-].
inline double motion_factor(const MotionSpec& m, double t) {
    constexpr double pi = std::numbers::pi;
    switch (m.kind) {
        case StructureMotion::velocity:
            if (t < m.ramp) return 0.5 * (t - m.ramp / pi * std::sin(pi * t / m.ramp));
            return t - 0.5 * m.ramp;
        case StructureMotion::sinusoid:
            return std::sin(2 * pi * t / m.period);
        case StructureMotion::table:
            return table_integral(m.factor, t);
        default:
            return 0;
    }
}

/// u(t) [m] of a structure that is not free.
inline Triple displacement_at(const MotionSpec& m, double t) {
    const Triple& of = m.kind == StructureMotion::sinusoid ? m.amplitude : m.velocity;
    const double factor = motion_factor(m, t);
    return {factor * of[0], factor * of[1], factor * of[2]};
}

}  // namespace moraine
