#pragma once
// [[stage]]: what changes between two steps of one run. Not collective.

#include <string>
#include <vector>

#include "core/scene_spec.hpp"
#include "io/input_error.hpp"

namespace moraine {

/// A stage as it is written.
struct StageText {
    StageSpec spec;
    bool has_damping = false;
    std::string ends_by;                     ///< until as a word
    std::vector<std::string> removes, adds;  ///< names of bodies
};

/// Whether a stage may set this key: a strength of a material, or how a wall acts. Throws InputError where not.
/// `path`: of the stage's set.
void check_setting(const Scene& scene, const std::string& setting, const std::string& path, const Places& places);

/// A property over depth is the particles', from the start: a stage whose settings put a number in its place is
/// refused. `changed`: the scene with them. Throws InputError.
void check_profiles_stay(const Scene& scene, const Scene& changed, const std::string& path, const Places& places);

/// When stages end, their damping, and which bodies come and go: to scene.course and scene.bodies. Materials and walls
/// are the caller's. Throws InputError.
void complete_stages(Scene& scene, const std::vector<StageText>& stages, const Places& places);

/// Whether two bodies are there in one stage.
bool meet(const Scene& scene, std::size_t a, std::size_t b);

/// What runs in stages cannot do with. Of a scene that is whole. Throws InputError.
void check_stages(const Scene& scene, const Places& places);

}  // namespace moraine
