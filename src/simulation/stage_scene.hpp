#pragma once
// The scene as it is in one of its stages: what the method of that stage is made of.

#include <cstddef>

#include "core/transfer/method.hpp"

namespace moraine {

/// In the stage of this number; the scene itself where it has none.
inline Scene scene_in_stage(const Scene& scene, std::size_t number) {
    Scene in_stage = scene;
    if (number >= scene.course.stages.size()) return in_stage;
    const StageSpec& stage = scene.course.stages[number];
    in_stage.materials = stage.materials;
    in_stage.walls = stage.walls;
    in_stage.course.tractions = stage.tractions;
    in_stage.damping = stage.damping;
    return in_stage;
}

/// Its method, for particles that have these columns.
template <class Real, int Dim>
Method<Host, Real, Dim> method_in_stage(const Scene& scene, std::size_t number, const ColumnNeeds& needs) {
    Method<Host, Real, Dim> method(scene_in_stage(scene, number));
    method.needs = needs;
    return method;
}

}  // namespace moraine
