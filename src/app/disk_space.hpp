#pragma once
// Whether the disk has space for the outputs that a run may write, told before the first step.

#include <string>

#include "core/scene_spec.hpp"

namespace moraine {

/// Free on the disk of a directory, or of the nearest one above it that exists [B]; 0: not known.
double free_disk_bytes(const std::string& directory);

/// A warning for a run that goes on from `time` [s]; empty: there is space, or that is not known. Compressed outputs
/// and those on cells are not judged.
std::string disk_warning(const Scene& scene, double time, double free_bytes);

}  // namespace moraine
