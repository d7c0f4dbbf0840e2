#pragma once
// `moraine check`: what a scene will need, as text.

#include <string>

#include "core/scene_spec.hpp"

namespace moraine {

/// What is asked about a scene.
struct CheckedRun {
    int ranks = 1;
    bool on_devices = false;
    bool writes_particles = true;
    std::string timing = {};  ///< what was measured of its time; empty: it is predicted
};

/// What `moraine check` prints: warnings, particles, blocks, step, time and memory. Not collective. Throws InputError
/// if a table of particles is bad.
std::string check_report(const Scene& scene, const CheckedRun& run);

}  // namespace moraine
