#include <fmt/format.h>

#include "scene/scene_check.hpp"

namespace moraine {

/// What acts on surfaces has quadratic weights and one round of forces in a step.
void check_bed(const Scene& scene, const Places& places) {
    if (scene.bed == Bed::nodes) return;
    const auto refuse_with = [&](const char* what, const char* why, const char* help) {
        refuse(places.of("numerics.bed"), fmt::format("numerics.bed = \"surface\" with {}", what), why, help);
    };
    if (scene.shape != Shape::quadratic)
        refuse_with("this numerics.shape", "it is for quadratic splines", "Use shape = \"quadratic\"?");
    if (scene.stress_update != StressUpdate::usl || scene.transfer == Transfer::fmpm)
        refuse_with("this stress_update or transfer", "surfaces act once in a step",
                    "Use stress_update = \"usl\" and no fmpm?");
}

}  // namespace moraine
