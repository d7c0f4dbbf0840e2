#pragma once
// For which scenes of several materials a device has gather and stress in one kernel for the blocks whose particles are
// all of one material (gpu/material_gathers.hpp): where each material alone would have it (comm/fused_gather.hpp), and
// none takes more from the grid than its motion, for what a fluid takes is asked of all particles of a scene.

#include <algorithm>

#include "comm/fused_gather.hpp"

namespace moraine {

inline bool fuses_by_block(const Scene& scene) {
    if (scene.materials.size() < 2) return false;
    Scene alone = scene;
    return std::all_of(scene.materials.begin(), scene.materials.end(), [&](const MaterialSpec& m) {
        alone.materials = {m};
        return !has_fluid_terms(m) && m.volumetric != Volumetric::grid && fuses(alone);
    });
}

}  // namespace moraine
