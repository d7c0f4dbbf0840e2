#include <fmt/format.h>

#include <optional>

#include "core/sleep/sleep.hpp"
#include "scene/scene_check.hpp"

namespace moraine {
namespace {

/// Sleepers take no part in rounds, have no noise of their own, and see nothing come.
std::optional<Hindrance> sleep_hindered_by(const Scene& scene) {
    const bool noisy = scene.transfer == Transfer::flip || scene.transfer == Transfer::aflip;
    if (scene.gravity == Triple{})
        return Hindrance{"numerics.sleep", "without gravity", "rest is measured by weight", "Set gravity?"};
    if (noisy || scene.transfer == Transfer::fmpm)
        return Hindrance{"numerics.sleep", "with this numerics.transfer",
                         noisy ? "the noise of FLIP keeps all awake" : "its rounds are the terms of a series",
                         "Use transfer = \"apic\"?"};
    if (scene.stress_update != StressUpdate::usl)
        return Hindrance{"numerics.sleep", "with this numerics.stress_update",
                         "sleepers take part in one round of a step", "Use stress_update = \"usl\"?"};
    for (const StructureSpec& s : scene.structures)
        if (turns(s.motion))
            return Hindrance{"numerics.sleep", "with structure." + s.name + ", which turns",
                             "whom a structure keeps awake is by its velocity alone", "Use sleep = \"off\"?"};
    return std::nullopt;
}

}  // namespace

void check_sleep(const Scene& scene, const Places& places) {
    if (!scene.sleep.on && !scene.output.sleep_forecast) return;
    if (const std::optional<Hindrance> found = sleep_hindered_by(scene))
        refuse(places.of(scene.sleep.on ? "numerics.sleep" : "output.block_loads"),
               fmt::format("{} {}", scene.sleep.on ? "numerics.sleep = \"on\"" : "output.block_loads = \"sleep\"",
                           found->what),
               found->why, found->help);
}

}  // namespace moraine
