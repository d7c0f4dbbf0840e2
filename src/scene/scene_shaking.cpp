#include "scene/scene_shaking.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/gravity.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

using enum KeyType;
using S = Scene;
using V = KeyValue;

constexpr double most_drift = 0.01;  // of the largest

const std::vector<KeyRow<Scene>> rows{
    // Resolved to Scene::course by the reader, which knows the tables.
    {{.table = "shaking",
      .name = "table",
      .type = name,
      .meaning = "Name of a table with the motion of the base; what is seen then is seen from the base."},
     [](S&, const V&) {}},
    {{.table = "shaking",
      .name = "quantity",
      .type = choice,
      .standard = "\"acceleration\"",
      .choices = {"acceleration", "velocity"},
      .meaning = "What its values are [m/s2, m/s]."},
     [](S& s, const V& v) { s.course.shaking.of_velocity = v.choice == 1; }},
    {{.table = "shaking",
      .name = "direction",
      .type = vector,
      .meaning = "In which the base moves where values are positive; of any length but 0."},
     [](S& s, const V& v) { s.course.shaking.direction = v.triple(); }},
    {{.table = "shaking",
      .name = "motion",
      .type = choice,
      .standard = "\"base\"",
      .choices = {"base", "outcrop", "upgoing"},
      .meaning = "base: of a rigid base; on one that absorbs, what it is of: rock where it crops out, or the wave that "
                 "comes up in it, which is half of that. Then all is seen from the outcrop."},
     [](S& s, const V& v) { s.course.shaking.motion = static_cast<BaseMotion>(v.choice); }},
    {{.table = "shaking",
      .name = "stage",
      .type = text,
      .standard = "",
      .meaning = "Name of the stage with which the table begins; left out: with the run."},
     [](S& s, const V& v) { s.course.shaking.stage_name = v.text; }},
    {{.table = "shaking",
      .name = "drift",
      .type = choice,
      .standard = "\"refuse\"",
      .choices = {"refuse", "keep"},
      .meaning = "Of a table that leaves the base moving, or away from where it was, by more than 1 % of its largest "
                 "velocity or way."},
     [](S& s, const V& v) { s.course.shaking.keeps_drift = v.choice == 1; }},
};

void complete_stage(Scene& scene, const Places& places) {
    ShakingSpec& shaking = scene.course.shaking;
    if (shaking.stage_name.empty()) return;
    std::vector<std::string> names;
    for (const StageSpec& stage : scene.course.stages) names.push_back(stage.name);
    const auto found = std::find(names.begin(), names.end(), shaking.stage_name);
    if (found == names.end())
        refuse(places.of("shaking.stage"), "shaking.stage = " + quote(shaking.stage_name), "there is no such stage",
               names.empty() ? "Write one as [[stage]]?" : suggest(shaking.stage_name, names));
    shaking.stage = static_cast<int>(found - names.begin());
    if (scene.course.stages[static_cast<std::size_t>(shaking.stage)].until_rest)
        refuse(places.of("shaking.stage"), "shaking.stage = " + quote(shaking.stage_name) + ", which ends at rest",
               "all may rest for a while before the base goes on", "Give that stage a time?");
}

/// The wall that the ground rests on: that on which gravity presses, or the lower end of the last axis.
std::pair<std::size_t, std::size_t> base_of(const Scene& scene) {
    std::size_t up = static_cast<std::size_t>(scene.dimensions) - 1;
    for (std::size_t a = 0; a < 3; ++a)
        if (std::fabs(scene.gravity[a]) > std::fabs(scene.gravity[up])) up = a;
    return {up, scene.gravity[up] > 0 ? 1 : 0};
}

/// A base that absorbs lets waves out into rock, whose motion without the ground above must be known.
void check_base(const Scene& scene, const Places& places) {
    const ShakingSpec& shaking = scene.course.shaking;
    const auto [up, side] = base_of(scene);
    const WallSpecs& walls =
        scene.course.stages.empty()
            ? scene.walls
            : scene.course.stages[shaking.stage < 0 ? 0 : static_cast<std::size_t>(shaking.stage)].walls;
    const bool absorbs = walls[up][side].absorbs, rigid = shaking.motion == BaseMotion::base;
    const std::string face = fmt::format("wall.{}-{}", "xyz"[up], side == 0 ? "min" : "max");
    if (absorbs && rigid)
        refuse(places.of("shaking"), fmt::format("shaking.motion = \"base\" with {}, which absorbs", face),
               "waves go out there, so its motion is not known before",
               "Use motion = \"outcrop\" or \"upgoing\", or another kind of wall?");
    if (!absorbs && !rigid)
        refuse(places.of("shaking.motion"), fmt::format("shaking.motion with {}, which is rigid", face),
               "it moves as its table says", fmt::format("Use motion = \"base\", or {}.kind = \"absorbing\"?", face));
}

void check_drift(const Scene& scene, const Places& places) {
    if (scene.course.shaking.keeps_drift) return;
    const BaseDrift drift = drift_of(scene.course.shaking);
    if (std::fabs(drift.velocity) <= most_drift * drift.largest_velocity &&
        std::fabs(drift.way) <= most_drift * drift.largest_way)
        return;
    refuse(places.of("shaking.table"),
           fmt::format("the base ends with {:.4g} m/s at {:.4g} m (at most {:.4g} m/s, {:.4g} m)", drift.velocity,
                       drift.way, drift.largest_velocity, drift.largest_way),
           "a record that is corrected ends at rest where it began", "Correct its baseline, or set drift = \"keep\"?");
}

}  // namespace

const std::vector<KeyRow<Scene>>& shaking_rows() {
    return rows;
}

BaseDrift drift_of(const ShakingSpec& shaking) {
    BaseDrift drift;
    double time = 0;
    const auto gained = [&](double t) { return base_acceleration(shaking, 0, time, t) * (t - time); };
    if (shaking.of_velocity) drift.velocity = base_velocity(shaking, 0, 0);
    const auto go_to = [&](double t) {
        const double from = drift.velocity, middle = from + gained(0.5 * (time + t));
        drift.velocity += gained(t);
        drift.way += (t - time) / 6 * (from + 4 * middle + drift.velocity);
        drift.largest_velocity = std::max(drift.largest_velocity, std::fabs(drift.velocity));
        drift.largest_way = std::max(drift.largest_way, std::fabs(drift.way));
        time = t;
    };
    for (const double t : shaking.table.times)
        if (t > 0) go_to(t);
    return drift;
}

void complete_shaking(Scene& scene, const Places& places) {
    ShakingSpec& shaking = scene.course.shaking;
    if (shaking.table.empty()) return;
    const double length = std::hypot(shaking.direction[0], shaking.direction[1], shaking.direction[2]);
    if (!(length > 0))
        refuse(places.of("shaking.direction"), "shaking.direction has no length", "it says where the base goes",
               "Write [1, 0], or [1, 0, 0] in 3-D?");
    for (double& d : shaking.direction) d /= length;
    complete_stage(scene, places);
    check_base(scene, places);
    check_drift(scene, places);
}

}  // namespace moraine
