#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "core/ground.hpp"
#include "io/terrain_model.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_terrain.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {

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

void load_gauges(Scene& scene, const Places& places) {
    if (scene.hazard.gauges_file.empty()) return;
    const std::string path = path_of_file(scene, scene.hazard.gauges_file);
    std::set<std::string> names;
    for (const GisShape& place : read_places(path, "hazard.gauges", scene.structures[0].ground->crs, scene.notices)) {
        const std::string& name = place.name;
        const bool good = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
            return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-';
        });
        if (!good || !names.insert(name).second)
            refuse(path, fmt::format("a gauge of the name {}", quote(name)),
                   good ? "it is there twice" : "a name has at most 64 letters, digits, _ and -", "Rename it?");
        const auto [x, y] = place.points[0];
        if (!(x >= scene.min[0] && x <= scene.max[0] && y >= scene.min[1] && y <= scene.max[1]))
            refuse(path, fmt::format("gauge {} is at ({:.10g}, {:.10g})", name, x, y), "outside the domain",
                   "Is it in the coordinates of the model?");
        scene.hazard.gauges.push_back({name, x, y});
    }
    if (scene.hazard.gauges.empty())
        refuse(places.of("hazard.gauges"), "hazard.gauges has no places", path, "Remove the key?");
}

}  // namespace moraine
