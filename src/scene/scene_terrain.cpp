#include "scene/scene_terrain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/terrain_file.hpp"
#include "scene/scene_keys.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {
namespace {

constexpr char axis_name[] = "xyz";

/// The key that has the model's path in a scene of these dimensions.
std::string key_of(const Scene& scene) {
    return scene.dimensions == 3 ? "terrain.dem" : "terrain.profile";
}

Ground read_model(const Scene& scene, const std::string& path, const Places& places) {
    const std::string key = key_of(scene), place = places.of(key);
    if (scene.dimensions == 2) {
        if (!path.ends_with(".csv"))
            refuse(place, fmt::format("{} = {}", key, quote(path)), "a profile is a table of x,z in a .csv",
                   "Convert or rename it?");
        return read_profile(path);
    }
    if (path.ends_with(".tif") || path.ends_with(".tiff") || path.ends_with(".nc"))
        refuse(place, fmt::format("{} = {}", key, quote(path)), "models are read as ESRI ASCII grids",
               "Convert it by gdal_translate -of AAIGrid?");
    if (!path.ends_with(".asc"))
        refuse(place, fmt::format("{} = {}", key, quote(path)), "must be an ESRI ASCII grid, .asc",
               "Convert or rename it?");
    return read_ascii_grid(path);
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

void load_ground(const Scene& scene, StructureSpec& spec, const Places& places) {
    const std::string key = key_of(scene), other = scene.dimensions == 3 ? "terrain.profile" : "terrain.dem";
    if (places.has(other))
        refuse(places.of(other), other + " is not used", fmt::format("the scene has {} dimensions", scene.dimensions),
               fmt::format("Write {}?", key));
    if (!places.has(key))
        refuse(places.of("terrain"), key + " is missing", "it is the path of the model",
               fmt::format("Add {} = ... to this table?", key.substr(8)));
    spec.name = "terrain";
    spec.shape = StructureShape::ground;
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        if (!(scene.max[a] > scene.min[a])) return;  // check_scene() refuses it
    const std::string path = path_of_file(scene, spec.file);
    const Ground all = read_model(scene, path, places);
    spec.ground =
        std::make_shared<const Ground>(cropped(all, path, {scene.min[0], scene.min[1]}, {scene.max[0], scene.max[1]}));
    for (std::size_t a = 0; a + 1 < static_cast<std::size_t>(scene.dimensions); ++a) {
        if (!scene.periodic[a]) continue;
        scene.dimensions == 2 ? check_period<2>(scene, *spec.ground, a, places)
                              : check_period<3>(scene, *spec.ground, a, places);
    }
    if (scene.periodic[static_cast<std::size_t>(scene.dimensions - 1)])
        refuse(places.of("domain.periodic"), "a periodic height", "the terrain is below, the sky above",
               fmt::format("Remove {} from domain.periodic?", axis_name[scene.dimensions - 1]));
}

void load_release(const Scene& scene, BodySpec& spec, const Places& places) {
    const std::string path = "release." + spec.name;
    if (scene.dimensions == 2)
        refuse(places.of(path), path + " in a scene of 2 dimensions", "an area is a polygon in plan",
               "Write it as [[body]]?");
    if (scene.structures.empty() || scene.structures[0].shape != StructureShape::ground)
        refuse(places.of(path), path + " without ground", "it is draped on the model of [terrain]", "Add [terrain]?");
    spec.shape = BodyShape::layer;
    spec.ground = scene.structures[0].ground;
    spec.points = read_polygon(path_of_file(scene, spec.file));
    if (spec.thickness < scene.cell)
        refuse(places.of(path + ".thickness"), fmt::format("{}.thickness = {}", path, spec.thickness),
               fmt::format("less than a cell, {} m; from 4 cells on a flow is resolved", scene.cell),
               "Use a smaller domain.cell?");
    for (const auto& p : spec.points)
        for (std::size_t a = 0; a < 2; ++a)
            if (!(p[a] >= scene.min[a] && p[a] <= scene.max[a]))
                refuse(places.of(path + ".area"),
                       fmt::format("{} has a corner at ({:.10g}, {:.10g})", path, p[0], p[1]),
                       fmt::format("the domain reaches from {:.10g} to {:.10g} along {}", scene.min[a], scene.max[a],
                                   axis_name[a]),
                       "Is it in the coordinates of the model?");
}

void check_hazard(const Scene& scene, const Places& places) {
    if (scene.dimensions == 2)
        refuse(places.of("hazard"), "[hazard] in a scene of 2 dimensions", "maps are in plan", "Remove it?");
    if (scene.structures.empty() || scene.structures[0].shape != StructureShape::ground)
        refuse(places.of("hazard"), "[hazard] without ground", "its maps lie on the model of [terrain]",
               "Add [terrain]?");
    if (scene.hazard.cell < scene.cell)
        refuse(places.of("hazard.cell"), fmt::format("hazard.cell = {}", scene.hazard.cell),
               fmt::format("less than domain.cell, {} m: columns would hold single particles", scene.cell),
               "Use a larger one?");
    const std::vector<std::string>& valid = hazard_map_names();
    for (const std::string& name : scene.hazard.maps)
        if (std::find(valid.begin(), valid.end(), name) == valid.end())
            refuse(places.of("hazard.maps"), fmt::format("hazard.maps has {}", quote(name)), "no such map",
                   suggest(name, valid));
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
        if (spec.density > 0 && material.density != spec.density)
            refuse(places.of(path + ".contact"), path + ".contact.density is missing",
                   fmt::format("the materials have {} and {} kg/m3", spec.density, material.density),
                   "Add density = ...?");
        spec.density = material.density;
    }
}

}  // namespace moraine
