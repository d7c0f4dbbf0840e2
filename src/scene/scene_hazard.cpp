#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "core/structures/ground.hpp"
#include "io/terrain_model.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_terrain.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {

void check_hazard(Scene& scene, const Places& places) {
    if (scene.dimensions == 2)
        refuse(places.of("hazard"), "[hazard] in a scene of 2 dimensions", "maps are in plan", "Remove it?");
    if (scene.structures.empty() || scene.structures[0].shape != StructureShape::ground)
        refuse(places.of("hazard"), "[hazard] without ground", "its maps lie on the model of [terrain]",
               "Add [terrain]?");
    if (scene.hazard.cell < scene.cell)
        refuse(places.of("hazard.cell"), fmt::format("hazard.cell = {}", scene.hazard.cell),
               fmt::format("less than domain.cell, {} m: columns would hold single particles", scene.cell),
               "Use a larger one?");
    scene.hazard.origin = scene.structures[0].ground->whole;
    const std::vector<std::string>& valid = hazard_map_names();
    for (const std::string& name : scene.hazard.maps)
        if (std::find(valid.begin(), valid.end(), name) == valid.end())
            refuse(places.of("hazard.maps"), fmt::format("hazard.maps has {}", quote(name)), "no such map",
                   suggest(name, valid));
}

namespace {

/// Names are columns of a table. `what`: gauge or section.
void check_name(const std::string& path, const char* what, const std::string& name, std::set<std::string>& names) {
    const bool good = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-';
    });
    if (!good || !names.insert(name).second)
        refuse(path, fmt::format("a {} of the name {}", what, quote(name)),
               good ? "it is there twice" : "a name has at most 64 letters, digits, _ and -", "Rename it?");
}

void check_inside(const Scene& scene, const std::string& path, const std::string& what,
                  const std::array<double, 2>& p) {
    if (!(p[0] >= scene.min[0] && p[0] <= scene.max[0] && p[1] >= scene.min[1] && p[1] <= scene.max[1]))
        refuse(path, fmt::format("{} ({:.10g}, {:.10g})", what, p[0], p[1]), "outside the domain",
               "Is it in the coordinates of the model?");
}

}  // namespace

void load_sections(Scene& scene, const Places& places) {
    if (scene.hazard.sections_file.empty()) return;
    require_file(scene, scene.hazard.sections_file, "hazard.sections", places);
    const std::string path = path_of_file(scene, scene.hazard.sections_file);
    std::set<std::string> names;
    std::size_t number = 0;
    for (const GisShape& line : read_lines(path, "hazard.sections", scene.structures[0].ground->crs, scene.notices)) {
        SectionSpec section{line.name, {}};
        ++number;
        if (section.name.empty()) section.name = fmt::format("section-{}", number);
        check_name(path, "section", section.name, names);
        for (const auto& p : line.points) {
            check_inside(scene, path, fmt::format("section {} has a point at", section.name), p);
            if (section.points.empty() || section.points.back() != p) section.points.push_back(p);
        }
        if (section.points.size() < 2)
            refuse(path, fmt::format("section {} has {} points", section.name, section.points.size()),
                   "at least 2 that differ are needed", "Is the file complete?");
        scene.hazard.sections.push_back(std::move(section));
    }
    if (scene.hazard.sections.empty())
        refuse(places.of("hazard.sections"), "hazard.sections has no lines", path, "Remove the key?");
}

void load_gauges(Scene& scene, const Places& places) {
    if (scene.hazard.gauges_file.empty()) return;
    require_file(scene, scene.hazard.gauges_file, "hazard.gauges", places);
    const std::string path = path_of_file(scene, scene.hazard.gauges_file);
    std::set<std::string> names;
    for (const GisShape& place : read_places(path, "hazard.gauges", scene.structures[0].ground->crs, scene.notices)) {
        check_name(path, "gauge", place.name, names);
        const auto [x, y] = place.points[0];
        check_inside(scene, path, fmt::format("gauge {} is at", place.name), {x, y});
        scene.hazard.gauges.push_back({place.name, x, y});
    }
    if (scene.hazard.gauges.empty())
        refuse(places.of("hazard.gauges"), "hazard.gauges has no places", path, "Remove the key?");
}

void load_path(Scene& scene, const Places& places) {
    if (scene.hazard.path_file.empty()) return;
    const std::string path = path_of_file(scene, scene.hazard.path_file);
    const std::vector<GisShape> lines = read_lines(path, "hazard.path", scene.structures[0].ground->crs, scene.notices);
    if (lines.size() != 1)
        refuse(places.of("hazard.path"), fmt::format("hazard.path has {} lines", lines.size()),
               fmt::format("{}: the way of the flow is one", path), "Keep one?");
    for (const auto& p : lines[0].points) {
        if (scene.hazard.path.empty()) check_inside(scene, path, "the path begins at", p);  // and may lead out of it
        if (scene.hazard.path.empty() || scene.hazard.path.back() != p) scene.hazard.path.push_back(p);
    }
    if (scene.hazard.path.size() < 2)
        refuse(path, fmt::format("the path has {} points", scene.hazard.path.size()),
               "at least 2 that differ are needed", "Is the file complete?");
}

}  // namespace moraine
