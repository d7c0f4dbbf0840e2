#include "predict/step_speed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace moraine {
namespace {

// On a core: dense columns, a layer of one cell and single cells within 10 % (benchmarks/step/results.md). They are
// host_costs of balance/weight.hpp, which lies above this folder.
constexpr double core_particle = 130e-9, core_block = 8e-6;  ///< [s]
constexpr double core_single = 0.89;                         ///< single over double precision
constexpr double plane_particle = 0.37, plane_block = 0.20;  ///< 2-D over 3-D, on one core of an AMD EPYC
// Over the FLIP that was measured: APIC and TPIC on a core and on a device; ground, where a thin flow lies on it with
// most of its blocks (27 % of the shipped valley's step on a core, 31 to 35 % of a slab's on one H100).
constexpr double affine_cost = 1.28, ground_cost = 1.4;

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

double core_seconds(const Scene& scene, const Prediction& prediction) {
    const bool plane = scene.dimensions == 2;
    const double particles = core_particle * static_cast<double>(prediction.particles) * (plane ? plane_particle : 1);
    const double blocks = core_block * static_cast<double>(prediction.blocks) * (plane ? plane_block : 1);
    return (particles + blocks) * (scene.precision == Precision::single_ ? core_single : 1);
}

bool lies_on_ground(const Scene& scene) {
    return std::any_of(scene.structures.begin(), scene.structures.end(),
                       [](const StructureSpec& s) { return s.shape == StructureShape::ground; });
}

}  // namespace

double substep_cost(int substeps) {
    return substeps == 1 ? 1 : 1.1 + 0.17 * substeps;
}

double step_seconds(const Scene& scene, const Prediction& prediction, bool on_device) {
    const bool single = scene.precision == Precision::single_;
    double seconds =
        on_device ? device_seconds(static_cast<double>(prediction.particles), single) : core_seconds(scene, prediction);
    if (is_affine(scene.transfer)) seconds *= affine_cost;
    if (lies_on_ground(scene)) seconds *= ground_cost;
    return seconds * substep_cost(prediction.substeps);
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
