#include "scene/scene_profiles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>

#include "core/data/error.hpp"
#include "core/material/laws.hpp"
#include "core/structures/ground.hpp"
#include "io/terrain_model.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_terrain.hpp"
#include "seeding/property_profile.hpp"
#include "seeding/seed.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {
namespace {

using enum KeyType;
using S = ProfileSpec;
using V = KeyValue;

const std::vector<KeyRow<ProfileSpec>> rows = in_tables<ProfileSpec>({
    {{.table = "material.su",
      .name = "surface",
      .type = real_or_text,
      .standard = "",
      .range = from_zero,
      .meaning = "The number at no depth, in the unit of the key; or a raster of it over terrain, relative to the "
                 "scene."},
     [](S& s, const V& v) { s.surface = v.real, s.file = v.text; }},
    {{.name = "gradient",
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
      .meaning = "Of a table in place of surface and gradient: rising depths, between which the number is linear and "
                 "beyond which it is constant."},
     [](S& s, const V& v) { s.depth = v.numbers; }},
    {{.name = "value", .type = list, .standard = "", .range = from_zero, .meaning = "The numbers there."},
     [](S& s, const V& v) { s.value = v.numbers; }},
});

void check_table(const ProfileSpec& profile, const SceneKey& key, const std::string& path, const Places& places) {
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
        refuse(places.of(at), at + " does not rise", "between two rows it is linear", "Put the rows in order?");
    for (const double value : profile.value)
        if (!key.range.holds(value))
            refuse(places.of(path + ".value"), fmt::format("{}.value = {}", path, shortest(value)),
                   "must be " + range_text(key.range), "Give every depth such a number?");
}

/// A property of a material: what it may be, and where it is written.
struct Written {
    KeyRange range;
    const char* unit;
    std::string path, place;
};

Written written(const MaterialSpec& m, std::size_t property, const Places& places) {
    const LawInfo& law = *find_law(m.law);
    const std::string path = fmt::format("material.{}.{}", m.name, property_name(law, property));
    if (property == law.parameters.size()) return {above_zero, "kg/m3", path, places.of(path)};
    const Parameter& parameter = law.parameters[property];
    return {parameter_key(law, parameter).range, parameter.unit, path, places.of(path)};
}

Written written(const MaterialSpec& m, const ProfileSpec& profile, const Places& places) {
    return written(m, static_cast<std::size_t>(profile.property), places);
}

std::string place_in(const Scene& scene, const BodySpec& body, const Triple& x) {
    return fmt::format("at ({:.6g}) in {}", fmt::join(x.begin(), x.begin() + scene.dimensions, ", "), path_of(body));
}

void check_depth(const BodySpec& body, const ProfileSpec& profile, const Written& key) {
    if (profile.counts_depth() && !profile.from && !has_surface(body))
        refuse(key.place, fmt::format("{} counts depth from the surface of {}", key.path, path_of(body)),
               "a table of particles and an inflow have none", "Add from = ..., the height at which depth begins?");
}

/// Whether bounds say already that every particle has a number of the range.
bool is_good_by_itself(const ProfileRange& bounds, const ProfileSpec& profile, const KeyRange& range) {
    return !profile.raster && range.holds(bounds.least) && range.holds(bounds.most);
}

void check_range(const Scene& scene, std::size_t body, const ProfileSpec& profile, const Places& places) {
    const BodySpec& spec = scene.bodies[body];
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(spec.material)];
    const Written key = written(m, profile, places);
    check_depth(spec, profile, key);
    if (is_good_by_itself(profile_bounds(scene, spec.material, profile), profile, key.range)) return;
    const ProfileRange found = profile_range(scene, static_cast<int>(body), profile);
    const std::string where = place_in(scene, spec, found.where);
    if (std::isnan(found.least))
        refuse(key.place, fmt::format("{} is not known {}", key.path, where), "the raster has no data there",
               "A raster that covers the body?");
    if (!key.range.holds(found.least))
        refuse(key.place, fmt::format("{} is {:.6g} {} {}", key.path, found.least, key.unit, where),
               "must be " + range_text(key.range), "A larger surface, or less loss with depth?");
    if (!key.range.holds(found.most))
        refuse(key.place, fmt::format("{} is up to {:.6g} {} in {}", key.path, found.most, key.unit, path_of(spec)),
               "must be " + range_text(key.range), "A smaller surface, or less gain with depth?");
}

/// The law's own words on numbers that are each within bounds, of all particles.
void check_together(const Scene& scene, std::size_t body, const Places& places) {
    const BodySpec& spec = scene.bodies[body];
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(spec.material)];
    const LawInfo& law = *find_law(m.law);
    const BodySeeds all(scene, static_cast<int>(body));
    std::vector<double> values = m.parameters;
    std::vector<Seed> seeds;
    for (std::int64_t row = 0; row < all.rows(); ++row) {
        seeds.clear();
        all.fill(row, row + 1, 1, seeds);
        for (const Seed& seed : seeds) {
            std::string what;
            for (const ProfileSpec& profile : m.profiles) {
                const auto k = static_cast<std::size_t>(profile.property);
                if (k == values.size()) continue;
                values[k] = profile_at(scene, spec, profile, seed.x);
                what += fmt::format("{}{} is {:.6g} {}", what.empty() ? "" : ", ", written(m, profile, places).path,
                                    values[k], law.parameters[k].unit);
            }
            if (const char* problem = law.problem(values.data()))
                throw InputError(fmt::format("{}: {} {}: {}", written(m, m.profiles[0], places).place, what,
                                             place_in(scene, spec, seed.x), problem));
        }
    }
}

/// Whether the law may find fault with some particles: it finds none with the least and the greatest numbers.
bool may_have_problem(const Scene& scene, const BodySpec& body, const MaterialSpec& m) {
    std::vector<double> least = m.parameters, most = m.parameters;
    for (const ProfileSpec& profile : m.profiles) {
        const auto k = static_cast<std::size_t>(profile.property);
        if (k == least.size()) continue;
        const ProfileRange bounds = profile_bounds(scene, body.material, profile);
        least[k] = bounds.least, most[k] = bounds.most;
    }
    const LawInfo& law = *find_law(m.law);
    return law.problem(least.data()) || law.problem(most.data());
}

}  // namespace

bool is_of_stiffness_or_density(const MaterialSpec& m, const ProfileSpec& profile) {
    return profile.property == 0 || &profile == m.density_profile();
}

namespace {

/// Where one stiffness and density of a material is asked for, a profile of either is refused.
void check_one_stiffness(const Scene& scene, const MaterialSpec& m, const Places& places) {
    for (const ProfileSpec& profile : m.profiles) {
        if (!is_of_stiffness_or_density(m, profile)) continue;
        const Written key = written(m, profile, places);
        const std::string path = "material." + m.name;
        if (m.volumetric == Volumetric::grid)
            refuse(places.of(path + ".volumetric"),
                   fmt::format("{}.volumetric = \"grid\" with {} over depth", path, key.path),
                   "pressures on cells are of one stiffness and density", "Use volumetric = \"cell\"?");
        if (has_fluid_terms(m))
            refuse(key.place, key.path + " over depth with pressure_smoothing or particle_shifting",
                   "these are of one stiffness and density", "Remove those keys?");
        for (const auto& axis : scene.walls)
            for (const WallSpec& wall : axis)
                if (wall.absorbs && wall.material == m.name)
                    refuse(key.place, key.path + " over depth of the material behind an absorbing wall",
                           "what is behind has one impedance", "Leave the wall's material out, or name another one?");
    }
}

/// Bounds in place of the numbers of profiles.
void bound_profiles(const Scene& scene, std::vector<MaterialSpec>& materials) {
    for (std::size_t k = 0; k < materials.size(); ++k)
        for (const ProfileSpec& profile : scene.materials[k].profiles) {
            const ProfileRange bounds = profile_bounds(scene, static_cast<int>(k), profile);
            const auto property = static_cast<std::size_t>(profile.property);
            MaterialSpec& m = materials[k];
            if (property < m.parameters.size()) {
                if (bounds.most > 0) m.parameters[property] = bounds.most;
            } else if (bounds.least > 0) {
                m.density = bounds.least;
            }
        }
}

bool is_undrained(const MaterialSpec& m) {
    const LawInfo& law = *find_law(m.law);
    return !law.of_file() && parameter_named(law, "su") >= 0;
}

/// Whether its undrained strength changes while it flows.
bool changes_strength(const MaterialSpec& m) {
    const LawInfo& law = *find_law(m.law);
    const auto value = [&](const char* key) {
        return m.parameters[static_cast<std::size_t>(parameter_named(law, key))];
    };
    return value("rate_log") > 0 || value("rate_power") > 0 || value("sensitivity") > 1;
}

/// Where the keys of its contact are written.
std::string path_of_contact(const StructureSpec& structure) {
    constexpr std::string_view wall = "wall-";
    if (structure.shape == StructureShape::ground) return "terrain.contact";
    if (structure.name.starts_with(wall)) return "wall." + structure.name.substr(wall.size());
    return "structure." + structure.name + ".contact";
}

/// Interfaces that follow the soil: what they count in, and who keeps its strength as it is now.
void follow_soil(Scene& scene, const Places& places) {
    const auto follows = std::find_if(scene.structures.begin(), scene.structures.end(),
                                      [](const StructureSpec& s) { return s.soil_su; });
    if (follows == scene.structures.end()) return;
    const std::string key = path_of_contact(*follows) + ".su";
    double greatest = 0;
    for (const BodySpec& body : scene.bodies) {
        const MaterialSpec& m = scene.materials[static_cast<std::size_t>(body.material)];
        if (!is_undrained(m))
            refuse(places.of(key), fmt::format("{} = \"soil\" beside {} of law \"{}\"", key, path_of(body), m.law),
                   "such soil has no undrained strength", "Give a number?");
        const int su = parameter_named(*find_law(m.law), "su");
        greatest = std::max(greatest, m.parameters[static_cast<std::size_t>(su)]);
    }
    for (StructureSpec& s : scene.structures)
        if (s.soil_su) s.su = greatest;
    for (std::size_t k = 0; k < scene.materials.size(); ++k) {
        if (!is_undrained(scene.materials[k])) continue;
        const auto su = static_cast<std::size_t>(parameter_named(*find_law(scene.materials[k].law), "su"));
        bool changes = changes_strength(scene.materials[k]);
        for (const StageSpec& stage : scene.course.stages)
            changes = changes || changes_strength(stage.materials[k]) ||
                      stage.materials[k].parameters[su] != scene.materials[k].parameters[su];
        scene.materials[k].keeps_strength = changes;
    }
}

}  // namespace

const std::vector<KeyRow<ProfileSpec>>& profile_rows() {
    return rows;
}

std::optional<double> check_profile(const ProfileSpec& profile, const SceneKey& key, const std::string& path,
                                    const Places& places) {
    if (!profile.depth.empty() || !profile.value.empty()) {
        check_table(profile, key, path, places);
        const auto [least, most] = std::minmax_element(profile.value.begin(), profile.value.end());
        return *least == *most ? std::optional(*least) : std::nullopt;
    }
    if (!places.has(path + ".surface"))
        refuse(places.of(path), path + ".surface is missing", "it is the number at no depth",
               "Add surface = ..., or a table of depth and value?");
    if (profile.gradient != 0 || !profile.file.empty()) return {};
    if (!key.range.holds(profile.surface))
        refuse(places.of(path), fmt::format("{}.surface = {}", path, shortest(profile.surface)),
               "must be " + range_text(key.range) + " where nothing is added with depth", "Add gradient = ...?");
    return profile.surface;
}

double number_before_bodies(const ProfileSpec& profile, const SceneKey& key) {
    double most = profile.surface;
    for (const double value : profile.value) most = std::max(most, value);
    if (most > 0 && key.range.holds(most)) return most;
    return std::isfinite(key.range.upper) ? key.range.upper : 1;
}

void load_profiles(Scene& scene, const Places& places) {
    for (MaterialSpec& m : scene.materials)
        for (ProfileSpec& profile : m.profiles) {
            if (profile.file.empty()) continue;
            const Written of = written(m, profile, places);
            const std::string key = of.path + ".surface";
            const bool ground = !scene.structures.empty() && scene.structures[0].shape == StructureShape::ground;
            if (scene.dimensions == 2 || !ground)
                refuse(places.of(key), fmt::format("{} is a raster", key), "rasters are over terrain in 3-D",
                       "Give a number?");
            require_file(scene, profile.file, key, places);
            const std::string name = of.path.substr(of.path.rfind('.') + 1);
            profile.raster = std::make_shared<const Ground>(read_values(
                path_of_file(scene, profile.file), {"raster of " + name, key, name}, *scene.structures[0].ground,
                {scene.min[0], scene.min[1]}, {scene.max[0], scene.max[1]}, scene.notices));
        }
}

void complete_profiles(Scene& scene, const Places& places) {
    for (const MaterialSpec& m : scene.materials) check_one_stiffness(scene, m, places);
    bound_profiles(scene, scene.materials);
    for (StageSpec& stage : scene.course.stages) bound_profiles(scene, stage.materials);
    follow_soil(scene, places);
    for (StageSpec& stage : scene.course.stages) {
        for (std::size_t k = 0; k < stage.materials.size(); ++k)
            stage.materials[k].keeps_strength = scene.materials[k].keeps_strength;
    }
    for (MaterialSpec& m : scene.materials) choose_law_over_depth(m);
    for (StageSpec& stage : scene.course.stages)
        for (MaterialSpec& m : stage.materials) choose_law_over_depth(m);
}

void check_properties(const Scene& scene, std::size_t body, const Places& places) {
    const BodySpec& spec = scene.bodies[body];
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(spec.material)];
    if (m.profiles.empty()) return;
    for (const ProfileSpec& profile : m.profiles) check_range(scene, body, profile, places);
    if (may_have_problem(scene, spec, m)) check_together(scene, body, places);
}

}  // namespace moraine
