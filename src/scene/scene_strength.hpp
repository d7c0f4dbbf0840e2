#pragma once
// A strength over depth or place: its table in a scene, its raster, and what must hold of it. Not collective.

#include <string>

#include "core/scene_spec.hpp"
#include "io/input_error.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {

/// What holds within a table that stands for the number of `key`, at `path`. Returns that number where it is the same
/// everywhere. Else the profile is of the parameter at `position`, and the number is 1, which nothing takes. Throws
/// InputError.
double check_profile(StrengthSpec& profile, int position, const SceneKey& key, const std::string& path,
                     const Places& places);

/// Reads the rasters that profiles of materials name, in the system of the terrain. Throws InputError.
void load_profiles(Scene& scene, const Places& places);

/// Whether every particle of a body has a strength that its law bears. Goes through the particles where that does not
/// follow from the profile's numbers. Throws InputError.
void check_strength(const Scene& scene, std::size_t body, const Places& places);

}  // namespace moraine
