#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/gravity.hpp"
#include "core/rest_interval.hpp"
#include "core/transfer/method.hpp"
#include "predict/prediction.hpp"
#include "scene/scene_check.hpp"

namespace moraine {
namespace {

constexpr double most_steps = 1e10;   // a year at 300 steps a second
constexpr double most_courant = 100;  // cells that a wave may cross in a step: none is stable far above 1

/// A fixed step against the waves of a body [m/s].
void check_fixed(const Scene& scene, const Places& places, double wave, double by_cfl) {
    const std::string mean = fmt::format("By cfl it would be {:.2g} s?", by_cfl);
    const double steps = scene.end / scene.dt, courant = scene.dt * wave / scene.cell;
    if (!(steps <= most_steps))
        refuse(places.of("time.dt"), fmt::format("time.dt = {:.6g} needs {:.2g} steps to time.end", scene.dt, steps),
               fmt::format("at most {:.0e}", most_steps), mean);
    if (!(courant <= most_courant))
        refuse(places.of("time.dt"), fmt::format("time.dt = {:.6g} lets waves cross {:.2g} cells", scene.dt, courant),
               fmt::format("unstable above about 1; at most {:.0f}", most_courant), mean);
}

void check_courant(const Scene& scene, const Places& places) {
    const double stable = stable_courant(scene.shape, scene.transfer, scene.stress_update);
    const double most = std::max(stable, accepted_courant);
    if (scene.dt > 0 || stable == 0 || scene.cfl <= most) return;
    refuse(places.of("time.cfl"), fmt::format("time.cfl = {:.6g} is more than is stable", scene.cfl),
           fmt::format("{:.3g} with this shape, transfer and stress update", stable),
           fmt::format("At most {:.2g}, or leave it out?", most));
}

/// Rest is of what has no clock of its own.
void check_rest(const Scene& scene, const Places& places) {
    std::string key = "time.stop", what = "time.stop = \"rest\"";
    bool looks = scene.rest.stops;
    for (const StageSpec& stage : scene.course.stages)
        if (stage.until_rest) looks = true, key = "stage." + stage.name + ".until", what = key + " = \"rest\"";
    if (!looks) return;
    if (rest_interval(scene) == 0)
        refuse(places.of(key), what + " without gravity", "there is no time by which all should rest",
               "Add rest.interval = ... [s]?");
    for (const StructureSpec& s : scene.structures)
        if (s.motion.kind != StructureMotion::fixed)
            refuse(places.of(key), fmt::format("{} with structure.{}, which moves", what, s.name),
                   "what rests now will not when it comes",
                   scene.rest.stops ? "Use time.stop = \"end\"?" : "Use a time?");
}

/// What takes gravity as it is for all of a run. key: what changes it.
std::optional<Hindrance> changing_gravity_hindered_by(const Scene& scene, const std::string& key) {
    const auto smooths = [](const MaterialSpec& m) { return has_fluid_terms(m); };
    if (scene.sleep.on || scene.output.sleep_forecast)
        return Hindrance{key, "with numerics.sleep or its forecast", "sleepers would not feel that gravity changes",
                         "Leave one of them out?"};
    if (std::any_of(scene.materials.begin(), scene.materials.end(), smooths))
        return Hindrance{key, "with pressure_smoothing or particle_shifting",
                         "they go by the head of a gravity that stays", "Leave one of them out?"};
    return std::nullopt;
}

void check_gravity(const Scene& scene, const Places& places) {
    if (!gravity_changes(scene)) return;
    const std::string key = scene.course.gravity.empty() ? "shaking" : "gravity_table";
    if (!scene.course.gravity.empty() && scene.gravity == Triple{})
        refuse(places.of(key), "gravity_table without gravity", "its values are factors of gravity", "Set gravity?");
    if (const std::optional<Hindrance> found = changing_gravity_hindered_by(scene, key))
        refuse(places.of(found->key), key + " " + found->what, found->why, found->help);
}

}  // namespace

void check_time(const Scene& scene, const Places& places) {
    check_courant(scene, places);
    check_rest(scene, places);
    check_gravity(scene, places);
    for (const BodySpec& body : scene.bodies) {
        const MaterialSpec& material = scene.materials[static_cast<std::size_t>(body.material)];
        const double wave = wave_speed(scene, body);
        const double by_cfl = courant_number(scene) * scene.cell / (wave + norm(body.velocity));
        if (scene.dt > 0) check_fixed(scene, places, wave, by_cfl);
        const double steps = scene.end / by_cfl;
        if (scene.dt > 0 || steps <= most_steps) continue;
        refuse(places.of("material." + material.name),
               fmt::format("body.{} with waves of {:.2g} m/s needs {:.2g} steps to time.end", body.name, wave, steps),
               fmt::format("{:.2g} s each; at most {:.0e} steps", by_cfl, most_steps),
               "Are young [Pa], density [kg/m3], velocity and time.end right?");
    }
}

}  // namespace moraine
