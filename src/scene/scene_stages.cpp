#include "scene/scene_stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string_view>

#include "scene/scene_changes.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

using enum KeyType;
using T = StageText;
using V = KeyValue;

const std::vector<KeyRow<StageText>> rows = in_tables<StageText>({
    {{.table = "stage", .name = "name", .type = name, .meaning = "In summary.json and messages."},
     [](T& t, const V& v) { t.spec.name = v.text; }},
    {{.name = "until",
      .type = real_or_text,
      .unit = "s",
      .standard = "",
      .range = {0, std::numeric_limits<double>::infinity(), true, false},
      .meaning =
          "It ends with the first step at or past this time; \"rest\": once all has come to rest, by [rest]. The "
          "last one ends the run: at time.end, or at rest."},
     [](T& t, const V& v) { t.spec.until = v.real, t.spec.until_rest = v.text == "rest", t.ends_by = v.text; }},
    {{.name = "damping", .standard = "", .range = {0, 1}, .meaning = "For its length; left out: numerics.damping."},
     [](T& t, const V& v) { t.spec.damping = v.real, t.has_damping = true; }},
    {{.name = "set",
      .type = settings,
      .standard = "",
      .meaning = "Strengths of materials, kinds of walls, and tractions from its begin on, as for --set: { "
                 "\"material.clay.su\" = 2e3, \"wall.x-max.kind\" = \"open\" }. Stress that is too much then returns "
                 "to the law's surface in "
                 "the next step."},
     [](T& t, const V& v) { t.spec.set = v.words; }},
    {{.name = "remove",
      .type = words,
      .standard = "[]",
      .meaning = "Names of bodies that are taken away as it begins."},
     [](T& t, const V& v) { t.removes = v.words; }},
    {{.name = "add",
      .type = words,
      .standard = "[]",
      .meaning = "Names of bodies that come as it begins, and are not there before; seeded as at the start."},
     [](T& t, const V& v) { t.adds = v.words; }},
});

std::vector<std::string> parts_of(const std::string& key) {
    std::vector<std::string> words(1);
    for (const char c : key)
        if (c == '.')
            words.emplace_back();
        else
            words.back() += c;
    return words;
}

std::string path_of(const StageSpec& stage) {
    return "stage." + stage.name;
}

/// Place of the body of this name in the scene.
std::size_t body_of(const Scene& scene, const std::string& name, const std::string& path, const Places& places) {
    std::vector<std::string> names;
    for (const BodySpec& body : scene.bodies) names.push_back(body.name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
        refuse(places.of(path), fmt::format("{} has {}", path, quote(name)), "there is no such body",
               suggest(name, names));
    return static_cast<std::size_t>(found - names.begin());
}

void complete_times(Scene& scene, const Places& places) {
    std::vector<StageSpec>& stages = scene.course.stages;
    double before = 0;
    for (StageSpec& stage : stages) {
        const std::string key = path_of(stage) + ".until";
        const bool last = &stage == &stages.back(), timed = places.has(key) && !stage.until_rest;
        if (last && timed)
            refuse(places.of(key), fmt::format("{} = {}", key, stage.until), "the last stage ends at time.end",
                   "Leave it out, or add a stage?");
        if (!last && !places.has(key))
            refuse(places.of(path_of(stage)), key + " is missing", "only the last stage ends with the run",
                   "Write until = \"rest\", or a time?");
        if (timed && stage.until <= before)
            refuse(places.of(key), fmt::format("{} = {}", key, stage.until),
                   fmt::format("the stage before ends at {} s", before), "Put stages in order?");
        if (!timed) stage.until = scene.end;
        if (timed) before = stage.until;
    }
}

void complete_bodies(Scene& scene, const std::vector<StageText>& texts, const Places& places) {
    constexpr int not_yet = -1;
    std::vector<int> gone(scene.bodies.size(), not_yet);
    std::vector<bool> comes(scene.bodies.size(), false);
    for (std::size_t k = 0; k < texts.size(); ++k)
        for (const std::string& name : texts[k].adds) {
            const std::string key = path_of(texts[k].spec) + ".add";
            const std::size_t b = body_of(scene, name, key, places);
            BodySpec& body = scene.bodies[b];
            if (k == 0)
                refuse(places.of(key), fmt::format("{} has {}", key, quote(name)),
                       "what the first stage has is there from the start", "Leave it out?");
            if (comes[b])
                refuse(places.of(key), fmt::format("{} has {}", key, quote(name)), "it comes twice", "Leave one out?");
            if (body.release_time > 0 || body.hydrograph)
                refuse(places.of(key), fmt::format("{} has {}", key, quote(name)), "it has a start of its own",
                       "Leave one of them out?");
            comes[b] = true;
            body.stage = static_cast<int>(k);
        }
    for (std::size_t k = 0; k < texts.size(); ++k)
        for (const std::string& name : texts[k].removes) {
            const std::string key = path_of(texts[k].spec) + ".remove";
            const std::size_t b = body_of(scene, name, key, places);
            const int now = static_cast<int>(k);
            if (gone[b] != not_yet || now <= scene.bodies[b].stage)
                refuse(places.of(key), fmt::format("{} has {}", key, quote(name)),
                       gone[b] != not_yet ? "it is gone already" : "it is not there before", "Leave it out?");
            gone[b] = now;
            scene.course.stages[k].removes.push_back(static_cast<int>(b));
        }
}

/// As whose part a body goes; beyond all where it stays.
int end_of(const Scene& scene, std::size_t body) {
    const std::vector<StageSpec>& stages = scene.course.stages;
    for (std::size_t k = 0; k < stages.size(); ++k)
        for (const int b : stages[k].removes)
            if (static_cast<std::size_t>(b) == body) return static_cast<int>(k);
    return std::numeric_limits<int>::max();
}

}  // namespace

const std::vector<KeyRow<StageText>>& stage_rows() {
    return rows;
}

void check_setting(const Scene& scene, const std::string& setting, const std::string& path, const Places& places) {
    const std::string key = setting.substr(0, setting.find('='));
    const std::vector<std::string> words = parts_of(key);
    const bool wall = words.size() == 3 && words[0] == "wall" &&
                      (words[2] == "kind" || words[2] == "friction" || words[2] == "material");
    const bool strength = words.size() == 3 && words[0] == "material" && is_strength(words.back());
    const bool load = words.size() == 3 && words[0] == "traction" && (words[2] == "pressure" || words[2] == "shear");
    if (!wall && !strength && !load)
        refuse(places.of(path), fmt::format("{} has {}", path, quote(key)),
               "stages change strengths of materials, kind and friction of walls, and tractions",
               "Is it material.NAME.su, cohesion, friction_angle, yield_stress, wall.FACE.kind, or "
               "traction.NAME.pressure?");
    for (const MaterialSpec& m : scene.materials)
        if (strength && m.name == words[1] && find_law(m.law)->of_file())
            refuse(places.of(path), fmt::format("{} has {}", path, quote(key)),
                   "what its keys are is known to the law's file alone", "Leave it out?");
}

void check_profiles_stay(const Scene& scene, const Scene& changed, const std::string& path, const Places& places) {
    for (std::size_t k = 0; k < scene.materials.size(); ++k) {
        const MaterialSpec& m = scene.materials[k];
        for (const auto& [of, other] : {std::pair{m, changed.materials[k]}, {changed.materials[k], m}})
            for (const ProfileSpec& profile : of.profiles) {
                const auto property = static_cast<std::size_t>(profile.property);
                if (other.profile_of(property)) continue;
                const char* name = property_name(*find_law(m.law), property);
                refuse(places.of(path), fmt::format("{} has \"material.{}.{}\"", path, m.name, name),
                       fmt::format("each particle keeps the {} over depth that it has from the start", name),
                       "Leave it out?");
            }
    }
}

void complete_stages(Scene& scene, const std::vector<StageText>& stages, const Places& places) {
    for (const StageText& text : stages) {
        const std::string key = path_of(text.spec) + ".until";
        if (!text.ends_by.empty() && !text.spec.until_rest)
            refuse(places.of(key), fmt::format("{} = {}", key, quote(text.ends_by)), "must be a time [s] or \"rest\"",
                   "Use until = \"rest\"?");
        StageSpec stage = text.spec;
        if (!text.has_damping) stage.damping = scene.damping;
        scene.course.stages.push_back(std::move(stage));
    }
    complete_times(scene, places);
    complete_bodies(scene, stages, places);
}

bool meet(const Scene& scene, std::size_t a, std::size_t b) {
    return scene.bodies[a].stage < end_of(scene, b) && scene.bodies[b].stage < end_of(scene, a);
}

void check_stages(const Scene& scene, const Places& places) {
    const std::vector<StageSpec>& stages = scene.course.stages;
    if (stages.empty()) return;
    if (scene.rest.stops)
        refuse(places.of("time.stop"), "time.stop = \"rest\" with stages", "each says when it ends",
               "Write until = \"rest\" in the last stage?");
    if (scene.sleep.on || scene.output.sleep_forecast)
        refuse(places.of("stage"), "stages with numerics.sleep or its forecast", "sleepers would not feel what changes",
               "Leave one of them out?");
    for (std::size_t k = 0; k + 1 < stages.size(); ++k)
        if (stages[k].damping > 0 && stages[k + 1].damping == 0 && !stages[k].until_rest)
            refuse(places.of(path_of(stages[k])), path_of(stages[k]) + " is damped until a time",
                   fmt::format("stage.{} is dynamic, and would begin with what the damping has not yet brought to rest",
                               stages[k + 1].name),
                   "Use until = \"rest\"?");
    for (const StageSpec& stage : stages)
        for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
            for (std::size_t s = 0; s < 2; ++s) {
                const auto has_law = [](const WallSpec& w) { return w.kind == WallKind::law && !w.absorbs; };
                if (has_law(scene.walls[a][s]) == has_law(stage.walls[a][s])) continue;
                const std::string face = fmt::format("{}-{}", "xyz"[a], s == 0 ? "min" : "max");
                refuse(
                    places.of(path_of(stage)), fmt::format("{} changes wall {} from or to a law", path_of(stage), face),
                    "a wall with a law is a structure", "Use none, no-slip, free-slip, friction, open or absorbing?");
            }
}

}  // namespace moraine
