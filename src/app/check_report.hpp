#pragma once
// `moraine check`: what a scene will need, as text.

#include <string>

#include "core/scene_spec.hpp"

namespace moraine {

/// What `moraine check` prints: particles, blocks, step and memory for `ranks` ranks. Not collective. Throws InputError
/// if a table of particles is bad.
std::string check_report(const Scene& scene, int ranks, bool writes_particles = true);

}  // namespace moraine
