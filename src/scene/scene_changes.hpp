#pragma once
// What a restart may change of a scene beside what is free to change in any (scene_identity.hpp): keys that the state
// of a particle does not depend on, each named by --allow-change. These are strengths of laws (the stress returns to
// the new surface in the next step), strengths of walls and structures, and numerics.damping. Geometry, cell, shape,
// density, elasticity and laws whose state knows their strength (modified-cam-clay) are what the checkpoint was made
// of. Blocks that sleep would not notice, so scenes with sleep change nothing.

#include <string>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

/// One key that a restart changed; values as scene_identity() has them.
struct SceneChange {
    std::string key, was, is;
};

/// Whether laws of the program call a strength so: what restarts and stages may change of a material.
bool is_strength(const std::string& key);

/// Throws InputError for a key of --allow-change that the scene has not, or that no restart may change. Not collective.
void check_allowed(const Scene& scene, const std::vector<std::string>& allowed);

/// Whether a restart may change this key of the identity, where it is named.
bool may_change(const Scene& scene, const std::string& key);

/// Of the allowed keys those in which `scene` differs from a stored identity, in the order of the identity.
std::vector<SceneChange> changes_from(const Scene& scene, const std::string& stored,
                                      const std::vector<std::string>& allowed);

}  // namespace moraine
