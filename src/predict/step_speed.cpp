#include "predict/step_speed.hpp"

#include <fmt/format.h>

#include <array>

namespace moraine {
namespace {

constexpr double core_rate_double = 6.39e6, core_rate_single = 7.18e6;  // particle-steps per second

/// A step on the device by its particles.
struct DeviceStep {
    double particles, double_ms, single_ms;
};
constexpr std::array<DeviceStep, 4> device_steps{{
    {195112, 0.130, 0.092},
    {2097152, 0.625, 0.339},
    {16777216, 4.428, 2.061},
    {64000000, 16.897, 7.669},
}};

/// Fewer particles than were measured do not fill the device: the least step; more take their share of the largest.
double device_seconds(double particles, bool single) {
    const auto ms = [&](const DeviceStep& row) { return single ? row.single_ms : row.double_ms; };
    if (particles <= device_steps.front().particles) return 1e-3 * ms(device_steps.front());
    for (std::size_t k = 1; k < device_steps.size(); ++k) {
        const DeviceStep &low = device_steps[k - 1], &high = device_steps[k];
        if (particles > high.particles) continue;
        const double share = (particles - low.particles) / (high.particles - low.particles);
        return 1e-3 * (ms(low) + share * (ms(high) - ms(low)));
    }
    return 1e-3 * ms(device_steps.back()) * particles / device_steps.back().particles;
}

}  // namespace

double substep_cost(int substeps) {
    return substeps == 1 ? 1 : 1.1 + 0.17 * substeps;
}

double step_seconds(const Scene& scene, const Prediction& prediction, bool on_device) {
    const bool single = scene.precision == Precision::single_;
    const auto particles = static_cast<double>(prediction.particles);
    const double plain =
        on_device ? device_seconds(particles, single) : particles / (single ? core_rate_single : core_rate_double);
    return plain * substep_cost(prediction.substeps);
}

std::string duration_text(double seconds) {
    if (seconds < 0.95) return fmt::format("{:.2g} s", seconds);
    if (seconds < 100) return fmt::format("{:.0f} s", seconds);
    if (seconds < 6000) return fmt::format("{:.0f} min", seconds / 60);
    if (seconds < 2 * 86400) return fmt::format("{:.1f} h", seconds / 3600);
    return fmt::format("{:.1f} days", seconds / 86400);
}

std::string run_time_text(const Scene& scene, const Prediction& prediction, int ranks, bool on_devices) {
    const double seconds = prediction.steps * step_seconds(scene, prediction, on_devices) / ranks;
    const std::string what = on_devices ? "NVIDIA H200" : "core";
    const std::string on = ranks == 1 ? "one " + what : fmt::format("{} {}s evenly loaded", ranks, what);
    return fmt::format("about {} on {}{}, without outputs", duration_text(seconds), on,
                       on_devices ? "" : " of an Intel Xeon (family 6, model 207)");
}

}  // namespace moraine
