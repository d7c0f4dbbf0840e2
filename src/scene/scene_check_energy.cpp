#include <fmt/format.h>

#include "core/gravity.hpp"
#include "scene/scene_check.hpp"

namespace moraine {

/// The budget needs nodes whose velocity all particles are moved by, and places that tell the potential energy.
void check_energy_budget(const Scene& scene, const Places& places) {
    if (!scene.output.energy_budget) return;
    const std::string on = "output.energy_budget = \"on\"";
    const std::string place = places.of("output.energy_budget");
    if (scene.transfer == Transfer::fmpm)
        refuse(place, on + " with transfer = \"fmpm\"", "its nodes hold terms of a series, which have no energy",
               "Use another transfer, or leave it out?");
    if (scene.sleep.on)
        refuse(place, on + " with numerics.sleep = \"on\"", "nodes of sleeping blocks are not stepped",
               "Leave one out?");
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        if (scene.periodic[a] && may_fall(scene, a))
            refuse(place,
                   fmt::format("{} with {} along {}, which is periodic", on,
                               scene.gravity[a] != 0 ? "gravity" : "shaking", "xyz"[a]),
                   "the potential energy jumps where particles come round", "Leave it out?");
}

}  // namespace moraine
