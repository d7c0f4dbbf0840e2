#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/structures/ground.hpp"
#include "io/terrain_model.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_terrain.hpp"
#include "seeding/seed_region.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {
namespace {

constexpr char axis_name[] = "xyz";

void check_release(const Scene& scene, const std::string& path, const Places& places) {
    if (scene.dimensions == 2)
        refuse(places.of(path), path + " in a scene of 2 dimensions", "an area is a polygon in plan",
               "Write it as [[body]]?");
    if (scene.structures.empty() || scene.structures[0].shape != StructureShape::ground)
        refuse(places.of(path), path + " without ground", "it is draped on the model of [terrain]", "Add [terrain]?");
}

/// Largest thickness of a raster in the polygon of a release, which must know one everywhere there.
double largest_of(const BodySpec& spec, const std::string& file) {
    double most = 0;
    const auto look = [&](double x, double y, double value) {
        if (std::isnan(value))
            refuse(file, fmt::format("no thickness at ({:.10g}, {:.10g})", x, y),
                   fmt::format("the raster has no data there, in release.{}", spec.name),
                   "Give it 0 where nothing is released?");
        if (value < 0)
            refuse(file, fmt::format("a thickness of {:.6g} at ({:.10g}, {:.10g})", value, x, y), "must be >= 0",
                   "Is it the right raster?");
        most = std::max(most, value);
    };
    const Ground& raster = *spec.thickness_raster.values;
    for (std::int64_t j = 0; j < raster.count[1]; ++j)
        for (std::int64_t i = 0; i < raster.count[0]; ++i) {
            const double x = raster.first[0] + static_cast<double>(i) * raster.spacing;
            const double y = raster.first[1] + static_cast<double>(j) * raster.spacing;
            if (is_in_polygon(spec, x, y)) look(x, y, raster.height[static_cast<std::size_t>(j * raster.count[0] + i)]);
        }
    for (const auto& p : spec.points) look(p[0], p[1], raster_value(raster, p[0], p[1]));
    return most;
}

void check_corners(const Scene& scene, const BodySpec& spec) {
    const std::string path = path_of(spec), file = path_of_file(scene, spec.file);
    if (spec.points.size() < 3)
        refuse(file, fmt::format("{} has {} corners", path, spec.points.size()), "at least 3 are needed",
               "Is the file complete?");
    for (const auto& p : spec.points)
        for (std::size_t a = 0; a < 2; ++a)
            if (!(p[a] >= scene.min[a] && p[a] <= scene.max[a]))
                refuse(file, fmt::format("{} has a corner at ({:.10g}, {:.10g})", path, p[0], p[1]),
                       fmt::format("the domain reaches from {:.10g} to {:.10g} along {}", scene.min[a], scene.max[a],
                                   axis_name[a]),
                       "Is it in the coordinates of the model?");
}

/// `place`: where the thickness is written.
void check_thickness(const Scene& scene, const BodySpec& spec, const std::string& place) {
    if (spec.thickness >= scene.cell) return;
    refuse(place,
           spec.thickness_raster.values ? fmt::format("{} is at most {:.6g} m thick", path_of(spec), spec.thickness)
                                        : fmt::format("{}.thickness = {}", path_of(spec), spec.thickness),
           fmt::format("less than a cell, {} m; from 4 cells on a flow is resolved", scene.cell),
           "Use a smaller domain.cell?");
}

}  // namespace

std::vector<BodySpec> load_releases(Scene& scene, BodySpec spec, const Places& places) {
    const std::string path = "release." + spec.name, name = spec.name;
    check_release(scene, path, places);
    spec.shape = BodyShape::layer;
    spec.ground = scene.structures[0].ground;
    require_file(scene, spec.file, path + ".area", places);
    require_file(scene, spec.thickness_raster.file, path + ".thickness", places);
    const std::vector<GisShape> areas =
        read_areas(path_of_file(scene, spec.file), path + ".area", spec.ground->crs, scene.notices);
    const std::string file = spec.thickness_raster.file.empty() ? "" : path_of_file(scene, spec.thickness_raster.file);
    if (!file.empty())
        spec.thickness_raster.values = std::make_shared<const Ground>(
            read_values(file, {"raster of thickness", path + ".thickness", "thickness"}, *spec.ground,
                        {scene.min[0], scene.min[1]}, {scene.max[0], scene.max[1]}, scene.notices));
    std::vector<BodySpec> all;
    for (const GisShape& area : areas) {
        spec.name = areas.size() == 1 ? name : fmt::format("{}-{}", name, all.size() + 1);
        spec.points = area.points;
        check_corners(scene, spec);
        if (!file.empty())
            spec.thickness = largest_of(spec, file);
        else if (!places.has(path + ".thickness")) {
            if (!area.thickness)
                refuse(places.of(path), path + ".thickness is missing", "and the polygon has no attribute of this name",
                       "Add thickness = ... to this table?");
            spec.thickness = *area.thickness;
        }
        check_thickness(scene, spec,
                        !file.empty()                     ? file
                        : places.has(path + ".thickness") ? places.of(path + ".thickness")
                                                          : path_of_file(scene, spec.file));
        all.push_back(spec);
    }
    return all;
}

}  // namespace moraine
