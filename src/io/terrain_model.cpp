#include "io/terrain_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/file_numbers.hpp"
#include "io/input_error.hpp"
#include "io/terrain_file.hpp"

namespace moraine {
namespace {

constexpr std::int64_t margin = 3;  // nodes beyond the domain: what is further off moves b by less than 1 %

void check_count(const NodeWindow& part, const std::string& path, const std::string& value) {
    const double nodes = static_cast<double>(part.count[0]) * static_cast<double>(part.count[1]);
    if (nodes > most_heights)
        refuse(path, fmt::format("{:.3g} {}s under the domain", nodes, value),
               fmt::format("{:.3g} GB on each rank; at most {:.2g} fit", 24e-9 * nodes, most_heights),
               "Take a coarser model?");
}

/// Nodes of a model that the box needs.
NodeWindow nodes_under(const Ground& all, const std::string& path, const PlanPoint& min, const PlanPoint& max) {
    NodeWindow part{{0, 0}, {1, 1}};
    for (std::size_t a = 0; a < (all.count[1] == 1 ? 1U : 2U); ++a) {
        const double low = (min[a] - all.first[a]) / all.spacing, high = (max[a] - all.first[a]) / all.spacing;
        const auto n = static_cast<double>(all.count[a]);
        if (low < -0.5 - 1e-9 || high > n - 0.5 + 1e-9)
            refuse(path,
                   fmt::format("the model reaches from {:.10g} to {:.10g} along {}", all.first[a] - 0.5 * all.spacing,
                               all.first[a] + (n - 0.5) * all.spacing, "xy"[a]),
                   fmt::format("the domain from {:.10g} to {:.10g}", min[a], max[a]),
                   "Shrink domain.min, domain.max, or take a larger model?");
        part.first[a] = std::max<std::int64_t>(0, std::llround(std::floor(low)) - margin);
        const std::int64_t last = std::min<std::int64_t>(all.count[a] - 1, std::llround(std::ceil(high)) + margin);
        part.count[a] = last - part.first[a] + 1;
        if (part.count[a] < 3)
            refuse(path, fmt::format("the model has {} heights along {} there", part.count[a], "xy"[a]),
                   "at least 3 are needed", "Take a finer model?");
    }
    check_count(part, path, "height");
    return part;
}

/// Nodes of a raster that lie in the box or are next to it.
NodeWindow nodes_within(const Ground& all, const std::string& path, const RasterUse& use, const PlanPoint& min,
                        const PlanPoint& max) {
    NodeWindow part;
    for (std::size_t a = 0; a < 2; ++a) {
        const double low = (min[a] - all.first[a]) / all.spacing, high = (max[a] - all.first[a]) / all.spacing;
        const double last = static_cast<double>(all.count[a] - 1);
        if (!(high > -0.5 && low < last + 0.5))
            refuse(path,
                   fmt::format("the {} reaches from {:.10g} to {:.10g} along {}", use.kind,
                               all.first[a] - 0.5 * all.spacing, all.first[a] + (last + 0.5) * all.spacing, "xy"[a]),
                   fmt::format("the domain from {:.10g} to {:.10g}", min[a], max[a]), "Is it of this place?");
        part.first[a] = std::llround(std::floor(std::max(0.0, low)));
        part.count[a] = std::llround(std::ceil(std::min(last, high))) - part.first[a] + 1;
    }
    check_count(part, path, use.value);
    return part;
}

Ground part_of(const Ground& all, const NodeWindow& w) {
    Ground part;
    part.spacing = all.spacing;
    part.crs = all.crs;
    part.count = w.count;
    for (std::size_t a = 0; a < 2; ++a) part.first[a] = all.first[a] + static_cast<double>(w.first[a]) * all.spacing;
    for (std::int64_t j = 0; j < w.count[1]; ++j) {
        const auto row = all.height.begin() + ((w.first[1] + j) * all.count[0] + w.first[0]);
        part.height.insert(part.height.end(), row, row + w.count[0]);
    }
    return part;
}

void require_heights(const Ground& part, const std::string& path) {
    for (std::int64_t j = 0; j < part.count[1]; ++j)
        for (std::int64_t i = 0; i < part.count[0]; ++i)
            if (std::isnan(part.height[static_cast<std::size_t>(j * part.count[0] + i)]))
                refuse(path,
                       fmt::format("no height at ({:.10g}, {:.10g})",
                                   part.first[0] + static_cast<double>(i) * part.spacing,
                                   part.first[1] + static_cast<double>(j) * part.spacing),
                       "the model has no data there, under the domain",
                       "Fill its gaps, or lay the domain inside of what is known, by its corners or by terrain.crop?");
}

/// Beyond the domain heights may be unknown: the model ends before the first row or column of its margin that has such
/// a one.
Ground without_unknown_margin(const Ground& part, const PlanBox& box) {
    std::array<std::int64_t, 2> low{}, high{};  // nodes kept, ends included: at first those whose cells have the box
    for (std::size_t a = 0; a < 2; ++a) {
        const double from = (box[0][a] - part.first[a]) / part.spacing, to = (box[1][a] - part.first[a]) / part.spacing;
        low[a] = std::max<std::int64_t>(0, std::llround(std::floor(from + 0.5 + 1e-9)));
        high[a] = std::min<std::int64_t>(part.count[a] - 1, std::llround(std::ceil(to - 0.5 - 1e-9)));
    }
    const auto is_known = [&](std::size_t a, std::int64_t at) {
        if (at < 0 || at >= part.count[a]) return false;
        for (std::int64_t k = low[1 - a]; k <= high[1 - a]; ++k)
            if (const std::int64_t i = a == 0 ? at : k, j = a == 0 ? k : at;
                std::isnan(part.height[static_cast<std::size_t>(j * part.count[0] + i)]))
                return false;
        return true;
    };
    NodeWindow kept;
    for (std::size_t a = 0; a < 2; ++a) {
        while (is_known(a, low[a] - 1)) --low[a];
        while (is_known(a, high[a] + 1)) ++high[a];
        kept.first[a] = low[a], kept.count[a] = high[a] - low[a] + 1;
    }
    return kept.count == part.count || std::min(kept.count[0], kept.count[1]) < 3 ? part : part_of(part, kept);
}

/// Numbers for "unknown" that nobody declared (-9999, -32767, 0 in the mountains) stand kilometres from what is beside
/// them: no ground does.
void refuse_leaps(const Ground& part, const std::string& path) {
    const double most = std::clamp(10 * part.spacing, 1000.0, 5000.0);
    for (std::int64_t k = 0; k < part.count[0] * part.count[1]; ++k)
        for (const std::int64_t step : {std::int64_t(1), part.count[0]}) {
            const bool last = step == 1 ? (k + 1) % part.count[0] == 0 : k + step >= part.count[0] * part.count[1];
            if (last) continue;
            const double z[2] = {part.height[static_cast<std::size_t>(k)],
                                 part.height[static_cast<std::size_t>(k + step)]};
            if (!(std::fabs(z[1] - z[0]) > most)) continue;  // or one is not known
            const auto at = [&](std::int64_t a) { return a == 0 ? k % part.count[0] : k / part.count[0]; };
            refuse(path,
                   fmt::format("heights of {:.7g} m and {:.7g} m side by side at ({:.10g}, {:.10g})", z[0], z[1],
                               part.first[0] + static_cast<double>(at(0)) * part.spacing,
                               part.first[1] + static_cast<double>(at(1)) * part.spacing),
                   fmt::format("{:.4g} m apart, under the domain or within {} cells of it", part.spacing, margin),
                   "Does one of them stand for no data? Declare it, by gdal_edit.py -a_nodata?");
        }
}

Ground read_part(const std::string& path, const RasterUse& use, const std::function<NodeWindow(const Ground&)>& window,
                 std::vector<std::string>& notices) {
    Ground part;
    if (has_ending(path, ".asc")) {
        Ground all = read_ascii_grid(path, use);
        all.crs = crs_beside(path);
        part = part_of(all, window(all));
    } else {
        part = read_gis_raster(path, use, window, notices);
    }
    if (use.value != "height") return part;
    refuse_leaps(part, path);
    check_scale(part, path);
    return part;
}

}  // namespace

Ground cropped(const Ground& all, const std::string& path, const PlanPoint& min, const PlanPoint& max) {
    Ground part = part_of(all, nodes_under(all, path, min, max));
    require_heights(part, path);
    part.fit();
    return part;
}

Ground read_model(const std::string& path, const PlanPoint& min, const PlanPoint& max,
                  std::vector<std::string>& notices) {
    return read_model(
        path,
        [&](const Ground&) {
            return PlanBox{min, max};
        },
        notices);
}

Ground read_model(const std::string& path, const std::function<PlanBox(const Ground&)>& under,
                  std::vector<std::string>& notices) {
    PlanBox box;
    const auto window = [&](const Ground& all) {
        box = under(all);
        return nodes_under(all, path, box[0], box[1]);
    };
    Ground part = without_unknown_margin(read_part(path, {}, window, notices), box);
    require_heights(part, path);
    part.fit();
    return part;
}

Ground read_values(const std::string& path, const RasterUse& use, const Ground& model, const PlanPoint& min,
                   const PlanPoint& max, std::vector<std::string>& notices) {
    const auto window = [&](const Ground& all) {
        if (!are_same_crs(all.crs, model.crs, min, max, 1e-3 * all.spacing))
            refuse(path, fmt::format("the {} has another coordinate system than the model", use.kind),
                   "rasters are not reprojected", "Reproject it by gdalwarp -t_srs?");
        return nodes_within(all, path, use, min, max);
    };
    return read_part(path, use, window, notices);
}

std::vector<GisShape> read_areas(const std::string& path, const std::string& key, const std::string& crs,
                                 std::vector<std::string>& notices) {
    const bool json = has_ending(path, ".geojson") || has_ending(path, ".json");
    if (has_ending(path, ".csv") || (json && !has_gdal())) {
        GisShape shape;
        shape.points = read_polygon(path, key);
        return {shape};
    }
    return read_gis_shapes(path, key, GisKind::polygon, crs, notices);
}

std::vector<GisShape> read_places(const std::string& path, const std::string& key, const std::string& crs,
                                  std::vector<std::string>& notices) {
    if (has_ending(path, ".csv")) return read_points(path, key);
    return read_gis_shapes(path, key, GisKind::point, crs, notices);
}

std::vector<GisShape> read_lines(const std::string& path, const std::string& key, const std::string& crs,
                                 std::vector<std::string>& notices) {
    const bool json = has_ending(path, ".geojson") || has_ending(path, ".json");
    if (json && !has_gdal()) return {read_line(path, key)};
    if (!has_ending(path, ".csv")) return read_gis_shapes(path, key, GisKind::line, crs, notices);
    std::vector<GisShape> lines;
    for (const GisShape& point : read_points(path, key)) {
        if (lines.empty() || lines.back().name != point.name) lines.push_back({{}, point.name, {}});
        lines.back().points.push_back(point.points[0]);
    }
    return lines;
}

}  // namespace moraine
