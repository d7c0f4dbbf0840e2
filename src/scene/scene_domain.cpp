// The domain of a scene over terrain that says none: in plan that of the model or of a crop, in height what the ground
// and the bodies on it need. Empty space costs nothing, so it is laid wide.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/structures/ground.hpp"
#include "core/structures/ground_curvature.hpp"
#include "io/terrain_model.hpp"
#include "scene/scene_terrain.hpp"
#include "seeding/seed_layer.hpp"
#include "seeding/seed_region.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {
namespace {

constexpr double spare = 8;  ///< under the lowest ground and over what may rise highest [cells]

/// Ends of the model along an axis: its outer heights.
std::array<double, 2> ends_of(const Ground& all, std::size_t a) {
    return {all.first[a], all.first[a] + static_cast<double>(all.count[a] - 1) * all.spacing};
}

/// Box of the polygons of terrain.crop, which must lie on the model.
PlanBox crop_box(Scene& scene, const StructureSpec& spec, const Ground& all) {
    const std::string path = path_of_file(scene, spec.crop_file);
    PlanBox box{{{1e300, 1e300}, {-1e300, -1e300}}};
    for (const GisShape& area : read_areas(path, "terrain.crop", all.crs, scene.notices))
        for (const auto& p : area.points)
            for (std::size_t a = 0; a < 2; ++a)
                box[0][a] = std::min(box[0][a], p[a]), box[1][a] = std::max(box[1][a], p[a]);
    for (std::size_t a = 0; a < 2; ++a) {
        const auto [low, high] = ends_of(all, a);
        const double half = (0.5 + 1e-9) * all.spacing;
        if (!(box[0][a] >= low - half && box[1][a] <= high + half))
            refuse(path,
                   fmt::format("the crop reaches from {:.10g} to {:.10g} along {}", box[0][a], box[1][a], "xy"[a]),
                   fmt::format("the model from {:.10g} to {:.10g}", low - 0.5 * all.spacing, high + 0.5 * all.spacing),
                   "Is it in the coordinates of the model?");
    }
    return box;
}

}  // namespace

void lay_domain(Scene& scene, const StructureSpec& spec, const Ground& all, const Places& places) {
    const bool crops = !spec.crop_file.empty();
    const double h = scene.cell;
    PlanBox box;
    if (crops) box = crop_box(scene, spec, all);
    for (std::size_t a = 0; a + 1 < static_cast<std::size_t>(scene.dimensions); ++a) {
        const auto [low, high] = ends_of(all, a);
        const double half = crops ? (0.5 + 1e-9) * all.spacing : 0;  // the model is good up to there
        double from = low, cells = std::floor((high - low) / h + 1e-9);
        if (crops) {
            from += h * std::floor((box[0][a] - low) / h + 1e-9);  // crops of one model share a grid
            if (from < low - half) from += h;
            cells = std::ceil((box[1][a] - from) / h - 1e-9);
            if (from + cells * h > high + half) cells -= 1;
        }
        if (!(cells >= 1))
            refuse(places.of("domain.cell"), fmt::format("domain.cell = {}", h),
                   fmt::format("the {} has less along {}", crops ? "crop" : "model", "xy"[a]), "Use a smaller one?");
        scene.min[a] = from, scene.max[a] = from + cells * h;
    }
}

void lay_height(Scene& scene) {
    const Ground& ground = *scene.structures[0].ground;
    const auto up = static_cast<std::size_t>(scene.dimensions - 1);
    const double h = scene.cell, g = std::hypot(scene.gravity[0], scene.gravity[1], scene.gravity[2]);
    const double low = ground.table[2][0];
    double high = ground.table[2][1];
    for (const BodySpec& body : scene.bodies) {
        double v = std::hypot(body.velocity[0], body.velocity[1], body.velocity[2]);
        if (body.hydrograph) v = *std::max_element(body.hydrograph->speed.begin(), body.hydrograph->speed.end());
        if (body.shape == BodyShape::table) continue;
        double top = extent_of(body, scene.dimensions).upper[up];
        if (body.shape == BodyShape::layer) top = std::max(top, layer_top(body));
        high = std::max(high, top + (g > 0 ? 0.5 * v * v / g : 0));
    }
    scene.min[up] = h * (std::floor(low / h) - spare);
    scene.max[up] = scene.min[up] + h * (std::ceil((high - scene.min[up]) / h) + spare);
}

void smooth_model(Scene& scene, const StructureSpec& spec, const std::string& path, Ground& ground,
                  const Places& places) {
    if (!(spec.smooth > 0)) return;
    const double before = least_radius(ground), change = smooth_ground(ground, spec.smooth);
    if (std::isnan(change))
        refuse(places.of("terrain.smooth"), fmt::format("terrain.smooth = {}", spec.smooth),
               fmt::format("the model bends by {:.3g} m and cannot be brought there by its neighbours' means", before),
               "Use a smaller one?");
    if (change > 0)
        scene.notices.push_back(
            fmt::format("{}: smoothed from a least radius of curvature of {:.3g} m to {:.3g} m; heights change by at "
                        "most {:.3g} m.",
                        path, before, least_radius(ground), change));
}

}  // namespace moraine
