#include <fmt/format.h>

#include <algorithm>

#include "core/transfer/method.hpp"
#include "scene/scene_check.hpp"

namespace moraine {
namespace {

std::string face_of(std::size_t a, std::size_t s) {
    return fmt::format("wall.{}-{}", "xyz"[a], s == 0 ? "min" : "max");
}

/// The faces of these walls that absorb, by their keys.
std::vector<std::string> absorbing(const WallSpecs& walls) {
    std::vector<std::string> found;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t s = 0; s < 2; ++s)
            if (walls[a][s].absorbs) found.push_back(face_of(a, s));
    return found;
}

void check_behind(const Scene& scene, const WallSpecs& walls, const Places& places) {
    std::vector<std::string> names;
    for (const MaterialSpec& m : scene.materials) names.push_back(m.name);
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t s = 0; s < 2; ++s) {
            const std::string& name = walls[a][s].material;
            const std::string key = face_of(a, s) + ".material";
            if (name.empty() || std::find(names.begin(), names.end(), name) != names.end()) continue;
            refuse(places.of(key), fmt::format("{} = {}", key, quote(name)), "there is no such material",
                   suggest(name, names));
        }
}

/// Ends bear what presses on them when they begin, and no more.
void check_start(const Scene& scene, const std::string& face, const Places& places) {
    if (std::all_of(scene.gravity.begin(), scene.gravity.end(), [](double g) { return g == 0; })) return;
    for (const BodySpec& body : scene.bodies)
        if (body.stage == 0 && !body.geostatic)
            refuse(places.of(face + ".kind"), fmt::format("{} absorbs from the start", face),
                   path_of(body) + " begins without stress, and the end bears only what presses on it when it begins",
                   "Give body.geostatic, or let a first [[stage]] come to rest on another kind of wall?");
}

/// What comes later would press on ends that do not bear it.
void check_bodies_stay(const Scene& scene, const std::string& face, int begins, const Places& places) {
    for (const BodySpec& body : scene.bodies)
        if (body.stage > begins || body.release_time > 0 || body.hydrograph)
            refuse(places.of(face + ".kind"), fmt::format("{} absorbs before {} is there", face, path_of(body)),
                   "an end bears only what presses on it when it begins",
                   "Let it absorb from a later [[stage]] on, or leave the body out?");
}

}  // namespace

void check_ends(const Scene& scene, const Places& places) {
    std::vector<const WallSpecs*> walls;
    for (const StageSpec& stage : scene.course.stages) walls.push_back(&stage.walls);
    if (walls.empty()) walls.push_back(&scene.walls);
    for (std::size_t k = 0; k < walls.size(); ++k) {
        const std::vector<std::string> faces = absorbing(*walls[k]);
        if (faces.empty()) continue;
        const std::string& face = faces.front();
        const auto refuse_with = [&](const std::string& what, const char* why, const char* help) {
            refuse(places.of(face + ".kind"), fmt::format("{} absorbs with {}", face, what), why, help);
        };
        check_behind(scene, *walls[k], places);
        if (!scene.boundary_spline && scene.shape != Shape::linear)
            refuse_with("numerics.boundary = \"plain\"", "the node on it would not have the velocity of the wall",
                        "Use boundary = \"spline\"?");
        if (uses_grid_pressure(scene))
            refuse_with("volumetric = \"grid\"", "pressures of cells know no waves", "Use \"cell\" or \"particle\"?");
        if (scene.bed == Bed::surface)
            refuse_with("numerics.bed = \"surface\"", "both act on one node", "Use bed = \"nodes\"?");
        if (scene.sleep.on) refuse_with("numerics.sleep", "sleepers would not feel waves", "Leave one of them out?");
        if (k == 0) check_start(scene, face, places);
        check_bodies_stay(scene, face, static_cast<int>(k), places);
        return;
    }
}

}  // namespace moraine
