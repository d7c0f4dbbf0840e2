#pragma once
// What makes the shipped slurries flow with their pressures on particles, a step at a time.

#include <string>
#include <vector>

namespace moraine::test {

/// Values for --set, `more` after them.
inline std::vector<std::string> particle_pressures(const std::vector<std::string>& more = {}) {
    std::vector<std::string> sets{"numerics.substeps=1", "material.slurry.volumetric=particle",
                                  "material.slurry.pressure_smoothing=0", "material.slurry.particle_shifting=0"};
    sets.insert(sets.end(), more.begin(), more.end());
    return sets;
}

}  // namespace moraine::test
