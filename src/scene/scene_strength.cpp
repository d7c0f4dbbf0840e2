#include "scene/scene_strength.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/data/error.hpp"
#include "core/material/laws.hpp"
#include "core/structures/ground.hpp"
#include "io/terrain_model.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_terrain.hpp"
#include "seeding/seed_table.hpp"
#include "seeding/strength_profile.hpp"

namespace moraine {
namespace {

using enum KeyType;
using S = StrengthSpec;
using V = KeyValue;

const std::vector<KeyRow<StrengthSpec>> rows = in_tables<StrengthSpec>({
    {{.table = "material.su",
      .name = "surface",
      .type = real_or_text,
      .unit = "Pa",
      .standard = "",
      .range = from_zero,
      .meaning = "Strength at no depth; or a raster of it over terrain, relative to the scene."},
     [](S& s, const V& v) { s.surface = v.real, s.file = v.text; }},
    {{.name = "gradient",
      .unit = "Pa/m",
      .standard = "0.0",
      .meaning =
          "What each metre of depth adds. Depth counts along gravity (without it, along the last axis), from where "
          "the line up from a particle leaves its body at the start; of a box, from the plane of its upper face."},
     [](S& s, const V& v) { s.gradient = v.real; }},
    {{.name = "from",
      .unit = "m",
      .standard = "",
      .meaning = "Height from which depth counts instead; above it there is none."},
     [](S& s, const V& v) { s.from = v.real; }},
    {{.name = "depth",
      .type = list,
      .unit = "m",
      .standard = "",
      .range = from_zero,
      .meaning = "Of a table in place of surface and gradient: rising depths, between which the strength is linear and "
                 "beyond which it is constant."},
     [](S& s, const V& v) { s.depth = v.numbers; }},
    {{.name = "value",
      .type = list,
      .unit = "Pa",
      .standard = "",
      .range = from_zero,
      .meaning = "The strengths there."},
     [](S& s, const V& v) { s.value = v.numbers; }},
});

void check_table(const StrengthSpec& profile, const SceneKey& key, const std::string& path, const Places& places) {
    const std::string at = path + ".depth";
    for (const char* other : {"surface", "gradient"})
        if (places.has(path + "." + other))
            refuse(places.of(path + "." + other), fmt::format("{}.{} and {} are both given", path, other, at),
                   "a profile is a line or a table", "Remove one of them?");
    if (profile.depth.size() != profile.value.size())
        refuse(places.of(at),
               fmt::format("{} has {} numbers and value {}", at, profile.depth.size(), profile.value.size()),
               "each depth has its value", "Give as many of both?");
    if (std::adjacent_find(profile.depth.begin(), profile.depth.end(), std::greater_equal<>()) != profile.depth.end())
        refuse(places.of(at), at + " does not rise", "between two rows the strength is linear",
               "Put the rows in order?");
    for (const double value : profile.value)
        if (!key.range.holds(value))
            refuse(places.of(path + ".value"), fmt::format("{}.value = {}", path, shortest(value)),
                   "must be " + range_text(key.range), "Give every depth its strength?");
}

/// Whether all numbers of the profile are strengths, and none falls with depth.
bool is_good_by_itself(const StrengthSpec& profile) {
    if (!profile.depth.empty()) return *std::min_element(profile.value.begin(), profile.value.end()) > 0;
    return !profile.raster && profile.surface > 0 && profile.gradient >= 0;
}

/// The material's key, and where it stands.
struct Written {
    std::string path, place;
};

Written written(const MaterialSpec& m, const Places& places) {
    const Parameter& parameter = find_law(m.law)->parameters[static_cast<std::size_t>(m.strength.parameter)];
    const std::string path = fmt::format("material.{}.{}", m.name, parameter.key);
    return {path, places.of(path)};
}

void check_depth(const Scene& scene, const BodySpec& body, const Places& places) {
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(body.material)];
    if (!m.strength.counts_depth()) return;
    const auto [path, place] = written(m, places);
    if (!m.strength.from && !has_surface(body))
        refuse(place, fmt::format("{} counts depth from the surface of {}", path, path_of(body)),
               "a table of particles and an inflow have none", "Add from = ..., the height at which depth begins?");
}

void check_least(const Scene& scene, const BodySpec& body, const StrengthRange& strength, const Places& places) {
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(body.material)];
    const LawInfo& law = *find_law(m.law);
    const auto k = static_cast<std::size_t>(m.strength.parameter);
    const double value = strength.least;
    const Triple& x = strength.where;
    std::vector<double> values = m.parameters;
    values[k] = value;
    const KeyRange range = parameter_key(law, law.parameters[k]).range;
    const char* problem = nullptr;
    if (range.holds(value) && !(problem = law.problem(values.data()))) return;
    const auto [path, place] = written(m, places);
    const std::string where =
        fmt::format("at ({:.6g}) in {}", fmt::join(x.begin(), x.begin() + scene.dimensions, ", "), path_of(body));
    if (std::isnan(value))
        refuse(place, fmt::format("{} is not known {}", path, where), "the raster has no data there",
               "A raster that covers the body?");
    const std::string what = fmt::format("{} is {:.6g} {} {}", path, value, law.parameters[k].unit, where);
    if (problem) throw InputError(fmt::format("{}: {}: {}", place, what, problem));
    refuse(place, what, "must be " + range_text(range), "A larger surface, or less loss with depth?");
}

}  // namespace

const std::vector<KeyRow<StrengthSpec>>& strength_rows() {
    return rows;
}

double check_profile(StrengthSpec& profile, int position, const SceneKey& key, const std::string& path,
                     const Places& places) {
    if (!profile.depth.empty() || !profile.value.empty()) {
        check_table(profile, key, path, places);
        const auto [least, most] = std::minmax_element(profile.value.begin(), profile.value.end());
        if (*least == *most) return *least;
    } else {
        if (!places.has(path + ".surface"))
            refuse(places.of(path), path + ".surface is missing", "it is the strength at no depth",
                   "Add surface = ..., or a table of depth and value?");
        if (profile.gradient == 0 && profile.file.empty()) {
            if (key.range.holds(profile.surface)) return profile.surface;
            refuse(places.of(path), fmt::format("{}.surface = {}", path, shortest(profile.surface)),
                   "must be " + range_text(key.range) + " where nothing is added with depth", "Add gradient = ...?");
        }
    }
    profile.parameter = position;
    return 1;
}

void load_profiles(Scene& scene, const Places& places) {
    for (MaterialSpec& m : scene.materials) {
        if (m.strength.file.empty()) continue;
        const std::string key = written(m, places).path + ".surface";
        const bool ground = !scene.structures.empty() && scene.structures[0].shape == StructureShape::ground;
        if (scene.dimensions == 2 || !ground)
            refuse(places.of(key), fmt::format("{} is a raster", key), "rasters are over terrain in 3-D",
                   "Give a number?");
        require_file(scene, m.strength.file, key, places);
        m.strength.raster = std::make_shared<const Ground>(read_values(
            path_of_file(scene, m.strength.file), {"raster of strength", key, "strength"}, *scene.structures[0].ground,
            {scene.min[0], scene.min[1]}, {scene.max[0], scene.max[1]}, scene.notices));
    }
}

void check_strength(const Scene& scene, std::size_t body, const Places& places) {
    const BodySpec& spec = scene.bodies[body];
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(spec.material)];
    if (!m.has_profile()) return;
    check_depth(scene, spec, places);
    if (is_good_by_itself(m.strength)) return;
    check_least(scene, spec, strength_range(scene, static_cast<int>(body)), places);
}

}  // namespace moraine
