#include <fmt/format.h>

#include <algorithm>

#include "core/sleep.hpp"
#include "scene/scene_check.hpp"

namespace moraine {
namespace {

/// Sleepers take no part in rounds, have no noise of their own, and see nothing come.
void check_method(const Scene& scene, const Places& places) {
    const bool noisy = scene.transfer == Transfer::flip || scene.transfer == Transfer::aflip;
    if (noisy || scene.transfer == Transfer::fmpm)
        refuse(places.of("numerics.sleep"), "numerics.sleep = \"on\" with this numerics.transfer",
               noisy ? "the noise of FLIP keeps all awake" : "its rounds are the terms of a series",
               "Use transfer = \"apic\"?");
    if (scene.stress_update != StressUpdate::usl)
        refuse(places.of("numerics.sleep"), "numerics.sleep = \"on\" with this numerics.stress_update",
               "sleepers take part in one round of a step", "Use stress_update = \"usl\"?");
}

}  // namespace

bool can_sleep(const Scene& scene) {
    const bool moves = std::any_of(scene.structures.begin(), scene.structures.end(),
                                   [](const StructureSpec& s) { return s.motion.kind != StructureMotion::fixed; });
    const bool smooth = scene.transfer != Transfer::flip && scene.transfer != Transfer::aflip;
    return scene.gravity != Triple{} && smooth && scene.transfer != Transfer::fmpm &&
           scene.stress_update == StressUpdate::usl && !moves;
}

void check_sleep(const Scene& scene, const Places& places) {
    if (!scene.sleep.on) return;
    if (scene.gravity == Triple{})
        refuse(places.of("numerics.sleep"), "numerics.sleep = \"on\" without gravity", "rest is measured by weight",
               "Set gravity?");
    check_method(scene, places);
    for (const StructureSpec& s : scene.structures)
        if (s.motion.kind != StructureMotion::fixed)
            refuse(places.of("numerics.sleep"),
                   fmt::format("numerics.sleep = \"on\" with structure.{}, which moves", s.name),
                   "sleepers do not see it come", "Remove it, or leave sleep off?");
}

}  // namespace moraine
