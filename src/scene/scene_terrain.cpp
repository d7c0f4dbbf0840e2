#include "scene/scene_terrain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "io/file_numbers.hpp"
#include "io/terrain_file.hpp"
#include "io/terrain_model.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {
namespace {

constexpr char axis_name[] = "xyz";

/// The key that has the model's path in a scene of these dimensions.
std::string key_of(const Scene& scene) {
    return scene.dimensions == 3 ? "terrain.dem" : "terrain.profile";
}

/// The part of the model that the domain needs.
Ground ground_under(Scene& scene, const StructureSpec& spec, const std::string& path, const Places& places) {
    std::array<double, 2> whole{};
    const auto under = [&](const Ground& all) {
        whole = all.first;
        if (!places.has("domain.min")) lay_domain(scene, spec, all, places);
        return PlanBox{{{scene.min[0], scene.min[1]}, {scene.max[0], scene.max[1]}}};
    };
    if (scene.dimensions == 3) {
        Ground ground = read_model(path, under, scene.notices);
        ground.whole = whole;
        return ground;
    }
    if (!has_ending(path, ".csv"))
        refuse(places.of(key_of(scene)), fmt::format("{} = {}", key_of(scene), quote(path)),
               "a profile is a table of x,z in a .csv", "Convert or rename it?");
    const Ground all = read_profile(path);
    const PlanBox box = under(all);
    return cropped(all, path, box[0], box[1]);
}

void check_crop(const Scene& scene, const StructureSpec& spec, const Places& places) {
    if (spec.crop_file.empty() || (scene.dimensions == 3 && !places.has("domain.min"))) return;
    refuse(places.of("terrain.crop"), "terrain.crop is not used",
           scene.dimensions == 2 ? "the scene has 2 dimensions" : "domain.min and domain.max say where the domain is",
           "Remove one of them?");
}

/// Values of a raster at the nodes of the ground; `otherwise` where it knows none.
std::vector<double> bed_values(Scene& scene, const Ground& ground, const std::string& file, const std::string& name,
                               double otherwise, bool zero_is_allowed) {
    if (file.empty()) return {};
    const std::string path = path_of_file(scene, file);
    const Ground raster = read_values(path, {"raster of " + name, "terrain." + name, name}, ground,
                                      {scene.min[0], scene.min[1]}, {scene.max[0], scene.max[1]}, scene.notices);
    for (double value : raster.height)
        if (!std::isnan(value) && !(zero_is_allowed ? value >= 0 : value > 0))
            refuse(path, fmt::format("a {} of {:.6g}", name, value), zero_is_allowed ? "must be >= 0" : "must be > 0",
                   "Give such cells the no-data value?");
    std::vector<double> values;
    for (std::int64_t j = 0; j < ground.count[1]; ++j)
        for (std::int64_t i = 0; i < ground.count[0]; ++i) {
            const double value = raster_value(raster, ground.first[0] + static_cast<double>(i) * ground.spacing,
                                              ground.first[1] + static_cast<double>(j) * ground.spacing);
            values.push_back(std::isnan(value) ? otherwise : value);
        }
    return values;
}

/// Rasters of the bed; each is for laws that have its value.
void load_bed(Scene& scene, const StructureSpec& spec, Ground& ground, const Places& places) {
    const auto check = [&](const std::string& file, const char* name, bool used) {
        const std::string key = fmt::format("terrain.{}", name);
        require_file(scene, file, key, places);
        if (file.empty() || (used && scene.dimensions == 3)) return;
        refuse(places.of(key), key + " is not used",
               used ? "rasters are for scenes of 3 dimensions" : fmt::format("the law of the bed has no {}", name),
               fmt::format("Remove it, or set terrain.contact.{}?", used ? name : "law"));
    };
    const bool voellmy = spec.law == InterfaceLaw::voellmy, undrained = spec.law == InterfaceLaw::undrained;
    check(spec.friction_file, "friction", voellmy || spec.law == InterfaceLaw::coulomb);
    check(spec.xi_file, "xi", voellmy);
    check(spec.su_file, "su", undrained);
    if (spec.soil_su && !spec.su_file.empty())
        refuse(places.of("terrain.su"), "terrain.su beside terrain.contact.su = \"soil\"",
               "the soil says the strength then", "Remove one of them?");
    ground.friction = bed_values(scene, ground, spec.friction_file, "friction", spec.friction, true);
    ground.xi = bed_values(scene, ground, spec.xi_file, "xi", spec.xi, false);
    ground.su = bed_values(scene, ground, spec.su_file, "su", spec.su, true);
}

/// What goes out at one end of a periodic axis comes in at the same height.
template <int Dim>
void check_period(const Scene& scene, const Ground& ground, std::size_t axis, const Places& places) {
    const std::size_t across = 1 - axis;
    const int steps =
        Dim == 2 ? 0 : static_cast<int>(std::lround((scene.max[across] - scene.min[across]) / scene.cell));
    for (int k = 0; k <= steps; ++k) {
        Vec<double, Dim> low = zero_vec<double, Dim>();
        low[static_cast<int>(axis)] = scene.min[axis];
        if (Dim == 3) low[static_cast<int>(across)] = scene.min[across] + k * scene.cell;
        Vec<double, Dim> high = low;
        high[static_cast<int>(axis)] = scene.max[axis];
        const double step = ground_at(ground.table.data(), high).height - ground_at(ground.table.data(), low).height;
        if (std::fabs(step) > 1e-3 * scene.cell)
            refuse(places.of("domain.periodic"), fmt::format("the terrain has a step of {:.3g} m", step),
                   fmt::format("between the ends of the periodic axis {}", axis_name[axis]),
                   "Remove the axis from domain.periodic?");
    }
}

}  // namespace

void require_file(const Scene& scene, const std::string& file, const std::string& key, const Places& places) {
    std::error_code none;
    if (!file.empty() && !std::filesystem::exists(path_of_file(scene, file), none))
        refuse(places.of(key), fmt::format("{} = {}", key, quote(file)),
               fmt::format("no such file: {}", path_of_file(scene, file)),
               "Is it relative to the folder of the scene?");
}

void load_ground(Scene& scene, StructureSpec& spec, const Places& places) {
    const std::string key = key_of(scene), other = scene.dimensions == 3 ? "terrain.profile" : "terrain.dem";
    if (places.has(other))
        refuse(places.of(other), other + " is not used", fmt::format("the scene has {} dimensions", scene.dimensions),
               fmt::format("Write {}?", key));
    if (!places.has(key))
        refuse(places.of("terrain"), key + " is missing", "it is the path of the model",
               fmt::format("Add {} = ... to this table?", key.substr(8)));
    spec.name = "terrain";
    spec.shape = StructureShape::ground;
    check_crop(scene, spec, places);
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        if (places.has("domain.min") && !(scene.max[a] > scene.min[a])) return;  // check_scene() refuses it
    require_file(scene, spec.file, key, places);
    require_file(scene, spec.crop_file, "terrain.crop", places);
    const std::string path = path_of_file(scene, spec.file);
    auto ground = std::make_shared<Ground>(ground_under(scene, spec, path, places));
    smooth_model(scene, spec, path, *ground, places);
    load_bed(scene, spec, *ground, places);
    spec.ground = ground;
    for (std::size_t a = 0; a + 1 < static_cast<std::size_t>(scene.dimensions); ++a) {
        if (!scene.periodic[a]) continue;
        scene.dimensions == 2 ? check_period<2>(scene, *spec.ground, a, places)
                              : check_period<3>(scene, *spec.ground, a, places);
    }
    if (scene.periodic[static_cast<std::size_t>(scene.dimensions - 1)])
        refuse(places.of("domain.periodic"), "a periodic height", "the terrain is below, the sky above",
               fmt::format("Remove {} from domain.periodic?", axis_name[scene.dimensions - 1]));
}

void open_faces(Scene& scene, const Places& places) {
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        for (std::size_t side = 0; side < 2; ++side)
            if (!scene.periodic[a] && !places.has(fmt::format("wall.{}-{}", axis_name[a], side == 0 ? "min" : "max")))
                scene.walls[a][side].kind = WallKind::open;
}

void complete_law(const Scene& scene, StructureSpec& spec, const std::string& path, const Places& places) {
    if (spec.law != InterfaceLaw::voellmy || spec.density > 0) return;
    for (const MaterialSpec& material : scene.materials) {
        if (material.density_profile())
            refuse(places.of(path), path + ".density is missing",
                   fmt::format("that of material.{} varies", material.name), "Add density = ...?");
        if (spec.density > 0 && material.density != spec.density)
            refuse(places.of(path), path + ".density is missing",
                   fmt::format("the materials have {} and {} kg/m3", spec.density, material.density),
                   "Add density = ...?");
        spec.density = material.density;
    }
}

}  // namespace moraine
