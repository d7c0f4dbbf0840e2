#include "scene/scene_defaults.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/courant.hpp"
#include "core/fluid/grid_pressure.hpp"
#include "core/gravity.hpp"
#include "core/material/laws.hpp"
#include "core/transfer/method.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {

namespace {

constexpr double smoothing = 0.22, shifting = 0.2;  ///< docs/adr/0008-filling.md

bool says(const MaterialSpec& m, const Places& places) {
    const std::string path = "material." + m.name;
    return places.has(path + ".volumetric") || places.has(path + ".pressure_smoothing") ||
           places.has(path + ".particle_shifting");
}

bool absorbs(const WallSpecs& walls) {
    return std::any_of(walls.begin(), walls.end(), [](const auto& axis) { return axis[0].absorbs || axis[1].absorbs; });
}

bool has_absorbing_walls(const Scene& scene) {
    const auto& stages = scene.course.stages;
    return absorbs(scene.walls) ||
           std::any_of(stages.begin(), stages.end(), [](const StageSpec& stage) { return absorbs(stage.walls); });
}

/// Pressures on cells are of one stiffness and density.
bool varies_in_stiffness(const MaterialSpec& m) {
    return std::any_of(m.profiles.begin(), m.profiles.end(),
                       [&](const ProfileSpec& profile) { return is_of_stiffness_or_density(m, profile); });
}

/// At nodes a bed acts up to 0.66 h away from where it is (docs/adr/0014-surfaces-where-they-are.md).
bool may_act_on_surfaces(const Scene& scene) {
    return scene.shape == Shape::quadratic && scene.stress_update == StressUpdate::usl &&
           scene.transfer != Transfer::fmpm && !has_absorbing_walls(scene);
}

/// Friction that follows pressure: where clay has no cures against crowding, a wave of its cells' pressures grows
/// there, and tension, which holds as well, is not counted.
bool rubs(const StructureSpec& s) {
    return s.law == InterfaceLaw::coulomb || s.law == InterfaceLaw::voellmy;
}

/// Whether pressures on cells are right with all else of the scene: beside structures that act at nodes still fluids
/// sink (docs/adr/0011-pressure-at-structures.md): who says nothing has surfaces with them.
bool bears_grid_pressure(const Scene& scene, const Places& places) {
    const bool friction = std::any_of(scene.structures.begin(), scene.structures.end(), rubs);
    const auto takes = [&](const MaterialSpec& m) {
        const LawInfo& law = *find_law(m.law);  // below Poisson's ratio 0.45 shear is nearly as fast as pressure
        return law.flows && (law.is_fluid || !friction) && law.is_nearly_incompressible(m.parameters.data()) &&
               !says(m, places) && !varies_in_stiffness(m);
    };
    return std::all_of(scene.materials.begin(), scene.materials.end(), takes) && may_act_on_surfaces(scene) &&
           (scene.structures.empty() || scene.bed == Bed::surface || !places.has("numerics.bed")) &&
           scene.course.tractions.empty() && !gravity_changes(scene);
}

/// What flows at one volume resists compression as water does, and shear hardly: pressures of particles lock, and
/// crowd fluids' particles.
void take_grid_pressure(Scene& scene) {
    if (!scene.structures.empty()) scene.bed = Bed::surface;
    const auto take = [](MaterialSpec& m) {
        m.volumetric = Volumetric::grid;
        if (find_law(m.law)->is_fluid) m.pressure_smoothing = smoothing, m.particle_shifting = shifting;
    };
    for (MaterialSpec& m : scene.materials) take(m);
    for (StageSpec& stage : scene.course.stages)
        for (MaterialSpec& m : stage.materials) take(m);
}

/// And keys that fluids have against crowding.
bool flows_at_one_volume(const Scene& scene) {
    return std::all_of(scene.materials.begin(), scene.materials.end(), [](const MaterialSpec& m) {
        const LawInfo& law = *find_law(m.law);
        return law.flows && m.volumetric == Volumetric::grid && (!law.is_fluid || has_fluid_terms(m));
    });
}

std::string material_text(const MaterialSpec& m) {
    std::string text;
    if (m.volumetric == Volumetric::grid) text = ", pressures on cells";
    if (m.volumetric == Volumetric::cell) text = ", means of cells";
    if (m.pressure_smoothing > 0) text += ", smoothed";
    if (m.particle_shifting > 0) text += ", shifted";
    return text.empty() ? text : "; " + m.name + ": " + text.substr(2);
}

}  // namespace

void take_defaults(Scene& scene, const Places& places) {
    const bool says_transfer = places.has("numerics.transfer");
    if (!says_transfer) scene.transfer = standard_transfer(scene.shape);
    if (bears_grid_pressure(scene, places)) take_grid_pressure(scene);
    if (!says_transfer && scene.shape == Shape::quadratic && !scene.sleep.on && flows_at_one_volume(scene))
        scene.transfer = Transfer::aflip;
    if (!places.has("numerics.flip")) scene.flip = standard_flip(scene.transfer);
    if (!places.has("time.cfl")) scene.cfl = standard_courant(scene);
    if (!places.has("numerics.substeps") || scene.substeps == substeps_by_scene)
        scene.substeps = bears_substeps(scene) ? most_substeps : 1;
}

std::string method_text(const Scene& scene) {
    const auto word = [](const char* key, int choice) {
        return key_of(scene_rows(), "numerics", key).choices[static_cast<std::size_t>(choice)];
    };
    std::string text = fmt::format("{} shapes, {}, {}", word("shape", static_cast<int>(scene.shape)),
                                   word("transfer", static_cast<int>(scene.transfer)),
                                   word("stress_update", static_cast<int>(scene.stress_update)));
    if (!scene.structures.empty())
        text += scene.bed == Bed::surface ? "; structures act on their surfaces" : "; structures act at nodes";
    for (const MaterialSpec& m : scene.materials) text += material_text(m);
    return text;
}

}  // namespace moraine
