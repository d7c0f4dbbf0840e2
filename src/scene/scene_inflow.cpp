// [[inflow]]: its table and its line over the terrain.
#include <fmt/format.h>

#include <algorithm>

#include "core/structures/ground.hpp"
#include "io/terrain_file.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_terrain.hpp"
#include "seeding/inflow.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {
namespace {

void check_line(const Scene& scene, BodySpec& spec, const std::string& path, const Places& places) {
    const std::string key = path + ".line";
    for (const auto& p : spec.points)
        for (std::size_t a = 0; a < 2; ++a)
            if (!(p[a] >= scene.min[a] && p[a] <= scene.max[a]))
                refuse(places.of(key), fmt::format("{} has a point at ({:.10g}, {:.10g})", key, p[0], p[1]),
                       fmt::format("the domain reaches from {:.10g} to {:.10g} along {}", scene.min[a], scene.max[a],
                                   "xy"[a]),
                       "Is it in the coordinates of the model?");
    spec.points.erase(std::unique(spec.points.begin(), spec.points.end()), spec.points.end());
    if (spec.points.size() < 2)
        refuse(places.of(key), fmt::format("{} has {} points", key, spec.points.size()),
               "at least 2 that differ are needed", "Write line = [[x, y], [x, y]]?");
}

void check_table(const std::string& file, const std::vector<std::array<double, 3>>& rows) {
    if (rows.size() < 2)
        refuse(file, fmt::format("{} rows", rows.size()), "an inflow begins and ends", "Is the file complete?");
    bool flows = false;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const auto& [time, discharge, speed] = rows[k];
        const std::string row = fmt::format("row {}", k + 1);
        if (time < 0 || (k > 0 && time <= rows[k - 1][0]))
            refuse(file, fmt::format("time = {} in {}", time, row), "times rise from 0 s on", "Put them in order?");
        if (discharge < 0)
            refuse(file, fmt::format("discharge = {} in {}", discharge, row), "must be >= 0 m3/s", "Is it the size?");
        if (!(speed > 0))
            refuse(file, fmt::format("speed = {} in {}", speed, row), "must be > 0 m/s: the depth follows from it",
                   "Give it a speed also where discharge is 0?");
        flows = flows || discharge > 0;
    }
    if (!flows) refuse(file, "discharge is 0 in all rows", "nothing would come in", "Is it the right column?");
}

}  // namespace

void load_inflow(Scene& scene, BodySpec& spec, const Places& places) {
    spec.shape = BodyShape::inflow;
    const std::string path = path_of(spec);
    if (scene.dimensions == 2)
        refuse(places.of(path), path + " in a scene of 2 dimensions", "it comes in over a line in plan",
               "Use a [[body]] with a velocity?");
    if (scene.structures.empty() || scene.structures[0].shape != StructureShape::ground)
        refuse(places.of(path), path + " without ground", "it flows in over the model of [terrain]", "Add [terrain]?");
    spec.ground = scene.structures[0].ground;
    check_line(scene, spec, path, places);
    require_file(scene, spec.file, path + ".table", places);
    const std::string file = path_of_file(scene, spec.file);
    const auto rows = read_hydrograph(file, path + ".table");
    check_table(file, rows);
    Hydrograph hydrograph;
    for (const auto& [time, discharge, speed] : rows) {
        hydrograph.time.push_back(time);
        hydrograph.discharge.push_back(discharge);
        hydrograph.speed.push_back(speed);
    }
    if (hydrograph.time[0] > 0 && hydrograph.time[0] >= scene.end)
        refuse(file, fmt::format("the first time is {} s", hydrograph.time[0]),
               fmt::format("the run ends at {} s", scene.end), "Does the table begin at 0?");
    spec.hydrograph = std::make_shared<const Hydrograph>(hydrograph);
    const Inflow inflow(scene, spec);
    hydrograph.volume = inflow.volume();
    spec.hydrograph = std::make_shared<const Hydrograph>(hydrograph);
    spec.thickness = inflow.deepest();
    if (const double peak = peak_depth(spec); peak < scene.cell)
        refuse(file, fmt::format("{} is at most {:.3g} m deep", path, peak),
               fmt::format("by discharge, speed and line, less than a cell, {} m; from 4 cells on a flow is resolved",
                           scene.cell),
               "Is its speed in m/s, or a smaller domain.cell?");
}

}  // namespace moraine
