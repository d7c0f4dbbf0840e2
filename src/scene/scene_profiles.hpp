#pragma once
// Properties over depth or place: their tables in a scene, their rasters, what must hold of them, and what else of the
// scene follows from them. Not collective.

#include <optional>
#include <string>

#include "core/scene_spec.hpp"
#include "io/input_error.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {

/// What holds within a table that stands for the number of `key`, at `path`. Returns that number where it is the same
/// everywhere. Throws InputError.
std::optional<double> check_profile(const ProfileSpec& profile, const SceneKey& key, const std::string& path,
                                    const Places& places);

/// What stands for the number of a property that is a profile, until bodies are known: within the key's range.
double number_before_bodies(const ProfileSpec& profile, const SceneKey& key);

/// Reads the rasters that profiles of materials name, in the system of the terrain. Throws InputError.
void load_profiles(Scene& scene, const Places& places);

/// Of all bodies, structures and stages: the bounds that stand for numbers of profiles, and which laws keep their
/// strength, because contacts follow it. Throws InputError for what does not go with them.
void complete_profiles(Scene& scene, const Places& places);

/// Whether every particle of a body has properties that its law bears. Goes through the particles where that does not
/// follow from the profiles' numbers. Throws InputError.
void check_properties(const Scene& scene, std::size_t body, const Places& places);

}  // namespace moraine
