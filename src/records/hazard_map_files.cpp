// The files of hazard maps: rank 0 gets one map at a time, as its tiles.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "core/data/error.hpp"
#include "core/structures/ground.hpp"
#include "io/disk_file.hpp"
#include "records/hazard_maps.hpp"
#include "records/map_style.hpp"
#include "records/outline.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

constexpr double unknown = -9999;  ///< NODATA

}  // namespace

double HazardMaps::value_of(int map, const std::array<std::int64_t, 2>& at, const Column& column) const {
    if (map < maps) return column.value[static_cast<std::size_t>(map)];
    Vec<double, 3> x = zero_vec<double, 3>();
    for (std::size_t a = 0; a < 2; ++a)
        x[static_cast<int>(a)] = begin(a, at[a]) + 0.5 * share(a, at[a]) * scene_.hazard.cell;
    const auto slope = ground_at<3>(scene_.structures[0].ground->table.data(), x).slope;
    return column.value[map == max_thickness ? max_depth : deposit] /
           std::sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
}

std::vector<HazardMaps::TileValues> HazardMaps::gathered(int map) const {
    std::vector<TileValues> mine;
    for (const auto& [number, tile] : tiles_) {
        mine.push_back({number, {}});
        for (std::size_t k = 0; k < in_tile; ++k) {
            const auto at = place_of(number, k);
            if (is_in_map(at)) mine.back().value[k] = value_of(map, at, tile[k]);
        }
    }
    std::vector<std::int64_t> counts(static_cast<std::size_t>(comm_.size()), 0);
    counts[0] = static_cast<std::int64_t>(mine.size());
    std::vector<TileValues> all = comm_.exchange(mine, counts);
    std::sort(all.begin(), all.end(), [](const TileValues& a, const TileValues& b) { return a.tile < b.tile; });
    return all;
}

/// Row j from the south; unknown where the flow was not.
template <class T>
void HazardMaps::fill_row(const std::vector<TileValues>& tiles, std::int64_t j, bool times, T* row) const {
    std::fill_n(row, size_[0], static_cast<T>(unknown));
    const std::int64_t edge = PlanColumns::edge, first = tiles_along_ * (j / edge);
    const auto before = [](const TileValues& tile, std::int64_t number) { return tile.tile < number; };
    auto tile = std::lower_bound(tiles.begin(), tiles.end(), first, before);
    for (; tile != tiles.end() && tile->tile < first + tiles_along_; ++tile) {
        const std::int64_t from = edge * (tile->tile - first);
        const auto values = tile->value.begin() + edge * (j % edge);
        std::transform(values, values + std::min(edge, size_[0] - from), row + from,
                       [&](double value) { return static_cast<T>(value == 0 && !times ? unknown : value); });
    }
}

/// As ESRI ASCII grid, row by row: as a whole it is larger than the map.
void HazardMaps::write_text(const std::string& path, int map, const std::vector<TileValues>& tiles) const {
    replace_file_by(path, [&](const auto& write) {
        write(
            fmt::format("ncols {}\nnrows {}\nxllcorner {:.10g}\nyllcorner {:.10g}\ncellsize {:.10g}\nNODATA_value {}\n",
                        size_[0], size_[1], corner_[0], corner_[1], scene_.hazard.cell, unknown));
        std::vector<double> row(static_cast<std::size_t>(size_[0]));
        for (std::int64_t j = size_[1] - 1; j >= 0; --j) {
            fill_row(tiles, j, map == arrival, row.data());
            std::string text;
            for (const double value : row) fmt::format_to(std::back_inserter(text), "{:.6g} ", value);
            text.back() = '\n';
            write(text);
        }
    });
}

/// As GeoTIFF.
std::string HazardMaps::image_of(int map, const std::vector<TileValues>& tiles, const MapTags& tags) const {
    static constexpr const char* units[files] = {"m", "m/s", "Pa", "m3/s2", "s", "m", "m", "m"};
    return geotiff_bytes({size_, corner_, scene_.hazard.cell, scene_.structures[0].ground->crs,
                          hazard_map_names()[static_cast<std::size_t>(map)], units[map], unknown,
                          [&](std::int64_t j, float* row) { fill_row(tiles, size_[1] - 1 - j, map == arrival, row); },
                          tags});
}

/// Of the part of the map that was reached.
std::string HazardMaps::outline(const std::vector<TileValues>& deepest, const MapTags& tags) const {
    std::vector<PlanCell> reached;
    for (const TileValues& tile : deepest)
        for (std::size_t k = 0; k < in_tile; ++k)
            if (const PlanCell at = place_of(tile.tile, k); tile.value[k] >= scene_.hazard.threshold && is_in_map(at))
                reached.push_back(at);
    PlanGrid map{size_, corner_, scene_.hazard.cell, {scene_.min[0], scene_.min[1]}, {}};
    for (std::size_t a = 0; a < 2; ++a) {
        map.end[a] = last_[a] == 1 ? corner_[a] + scene_.hazard.cell * static_cast<double>(size_[a]) : scene_.max[a];
        if (first_[a] == 1) map.begin[a] = corner_[a];
    }
    const auto polygons = outline_of(std::move(reached), map);
    return by_gdal_ ? outline_bytes(polygons, scene_.structures[0].ground->crs, scene_.hazard.threshold, tags)
                    : outline_json(polygons, scene_.hazard.threshold);
}

std::string HazardMaps::prepare(const std::string& directory) {
    const std::string folder = directory + "/maps";
    comm_.agree_no_error<InputError>(message_of([&] {
        if (comm_.is_root() && std::filesystem::exists(folder) && !std::filesystem::is_directory(folder))
            throw InputError(fmt::format("cannot write into {} (it is not a directory). Another --output?", folder));
    }));
    if (!comm_.is_root() || !by_gdal_) return {};
    const std::string trouble = message_of([&] {
        const std::string& crs = scene_.structures[0].ground->crs;
        geotiff_bytes({{1, 1}, {0, 0}, 1, crs, "depth", "m", unknown, [](std::int64_t, float* row) { *row = 0; }, {}});
        outline_bytes({}, crs, 1, {});
    });
    by_gdal_ = trouble.empty();
    return by_gdal_ ? "" : fmt::format("hazard maps will be .asc and .geojson: {}", trouble);
}

/// Of a map: the largest value of its tiles.
double HazardMaps::most_of(const std::vector<TileValues>& tiles) {
    double most = 0;
    for (const TileValues& tile : tiles) most = std::max(most, *std::max_element(tile.value.begin(), tile.value.end()));
    return most;
}

void HazardMaps::write(const std::string& directory, const MapTags& tags) const {
    const std::filesystem::path folder = std::filesystem::path(directory) / "maps";
    std::string trouble = message_of([&] {
        if (comm_.is_root()) std::filesystem::create_directories(folder);
    });
    for (int map = 0; map < files; ++map) {
        const std::string& name = hazard_map_names()[static_cast<std::size_t>(map)];
        const auto& list = scene_.hazard.maps;
        const bool wanted = std::find(list.begin(), list.end(), name) != list.end();
        if (!wanted && map != max_depth) continue;
        const std::vector<TileValues> tiles = gathered(map);
        if (!comm_.is_root() || !trouble.empty()) continue;
        trouble = message_of([&] {
            if (wanted) {
                by_gdal_ ? replace_file((folder / (name + ".tif")).string(), image_of(map, tiles, tags))
                         : write_text((folder / (name + ".asc")).string(), map, tiles);
                replace_file((folder / (name + ".qml")).string(), map_style(name, most_of(tiles)));
            }
            if (map == max_depth)
                replace_file((folder / (by_gdal_ ? "outline.gpkg" : "outline.geojson")).string(), outline(tiles, tags));
        });
    }
    comm_.agree_no_error<MachineError>(trouble);
}

}  // namespace moraine
