#include "records/hazard_maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "core/ground.hpp"
#include "core/morton.hpp"
#include "io/disk_file.hpp"
#include "records/outline.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

constexpr double never = -9999;  ///< NODATA of arrival

}  // namespace

HazardMaps::HazardMaps(const Scene& scene, const Comm& comm) : scene_(scene), comm_(comm) {
    const double a = scene.hazard.cell;
    for (std::size_t axis = 0; axis < 2; ++axis)
        size_[axis] = std::llround(std::ceil((scene.max[axis] - scene.min[axis]) / a - 1e-9));
    double density = 0;
    for (const MaterialSpec& material : scene.materials) density = std::max(density, material.density);
    volume_unit_ = std::ldexp(a * a * scene.cell, -36);  // 2^27 cells deep fit
    mass_unit_ = density * volume_unit_;
    momentum_unit_ = 64 * mass_unit_;  // of 1 m/s
    columns_.assign(static_cast<std::size_t>(size_[0] * size_[1]), Column{});
    for (Column& c : columns_) c[arrival] = never;
    find_ground();
}

/// Of places half a cell of the terrain model apart or closer.
void HazardMaps::find_ground() {
    const Ground& ground = *scene_.structures[0].ground;
    const double a = scene_.hazard.cell;
    const int pieces = std::max(2, static_cast<int>(std::ceil(2 * a / ground.spacing)));
    floor_.resize(columns_.size());
    rise_.resize(columns_.size());
#pragma omp parallel for schedule(static)
    for (std::size_t k = 0; k < columns_.size(); ++k) {
        const std::size_t index[2] = {k % static_cast<std::size_t>(size_[0]), k / static_cast<std::size_t>(size_[0])};
        double low = std::numeric_limits<double>::max(), high = -low;
        for (int n = 0; n < (pieces + 1) * (pieces + 1); ++n) {
            const int part[2] = {n % (pieces + 1), n / (pieces + 1)};
            Vec<double, 3> x = zero_vec<double, 3>();
            for (std::size_t b = 0; b < 2; ++b)
                x[static_cast<int>(b)] = scene_.min[b] + a * (static_cast<double>(index[b]) + double(part[b]) / pieces);
            const double height = ground_at<3>(ground.table.data(), x).height;
            low = std::min(low, height), high = std::max(high, height);
        }
        floor_[k] = low;
        rise_[k] = static_cast<int>(std::min(63.0, std::floor((high - low) / scene_.cell) + 1));
    }
}

/// Those over the occupied blocks of all ranks are summed.
template <class Real>
PlanColumns HazardMaps::columns_of(const Simulation<Real, 3>& sim) const {
    PlanColumns c{sim.plan_places(), scene_.hazard.cell, {size_[0], size_[1]}, {}, {},
                  volume_unit_,      mass_unit_,         momentum_unit_};
    const std::int64_t most = std::numeric_limits<std::int64_t>::max();
    std::int64_t low[2] = {most, most}, high[2] = {-1, -1};
    for (Key key : sim.block_counts().key) {
        const auto at = Morton<3>::decode(key);
        for (std::size_t a = 0; a < 2; ++a) {
            const auto block = static_cast<std::int32_t>(at[a]);
            const int axis = static_cast<int>(a);
            low[a] = std::min(low[a], c.along(axis, c.places.at(axis, block, 0)));
            high[a] = std::max(high[a], c.along(axis, c.places.at(axis, block, 4)));
        }
    }
    for (std::size_t a = 0; a < 2; ++a) {
        const std::int64_t from = -comm_.max(-low[a]), to = comm_.max(high[a]);
        if (from > to) continue;  // all have left
        c.first[a] = from;
        c.count[a] = to - from + 1;
    }
    return c;
}

HazardMaps::Flow HazardMaps::flow_of(const std::int64_t* s) const {
    if (s[1] == 0) return {};
    const double plan = scene_.hazard.cell * scene_.hazard.cell;
    const double volume = static_cast<double>(s[0]) * volume_unit_, depth = volume / plan;
    if (depth < scene_.hazard.threshold) return {depth, 0, 0};
    const double mass = static_cast<double>(s[1]) * mass_unit_;
    const double speed = momentum_unit_ / mass *
                         std::hypot(static_cast<double>(s[2]), static_cast<double>(s[3]), static_cast<double>(s[4]));
    return {depth, speed, mass / volume * speed * speed};
}

void HazardMaps::take(double time, const PlanColumns& seen, const std::vector<std::int64_t>& sums) {
    for (Column& c : columns_) c[deposit] = 0;
    for (std::int64_t j = seen.first[1]; j < seen.first[1] + seen.count[1]; ++j)
        for (std::int64_t i = seen.first[0]; i < seen.first[0] + seen.count[0]; ++i) {
            const Flow f = flow_of(sums.data() + seen.place(i, j));
            if (f.depth == 0) continue;
            Column& c = columns_[static_cast<std::size_t>(i + size_[0] * j)];
            c[deposit] = f.depth;
            c[max_depth] = std::max(c[max_depth], f.depth);
            if (f.depth < scene_.hazard.threshold) continue;
            if (c[arrival] == never) c[arrival] = time;
            c[max_speed] = std::max(c[max_speed], f.speed);
            c[max_pressure] = std::max(c[max_pressure], f.pressure);
            c[max_momentum_flux] = std::max(c[max_momentum_flux], f.depth * f.speed * f.speed);
        }
}

std::vector<std::string> HazardMaps::gauge_columns() const {
    std::vector<std::string> names{"step", "time_s"};
    for (const GaugeSpec& gauge : scene_.hazard.gauges)
        for (const char* what : {"depth_m", "speed_m_s", "pressure_Pa"}) names.push_back(gauge.name + "_" + what);
    return names;
}

void HazardMaps::observe_gauges(const PlanColumns& seen, const std::vector<std::int64_t>& sums) {
    gauges_.clear();
    for (const GaugeSpec& gauge : scene_.hazard.gauges) {
        const std::int64_t i = seen.along(0, gauge.x), j = seen.along(1, gauge.y);
        const std::int64_t beyond[2] = {i - seen.first[0], j - seen.first[1]};
        Flow f;
        if (beyond[0] >= 0 && beyond[1] >= 0 && beyond[0] < seen.count[0] && beyond[1] < seen.count[1])
            f = flow_of(sums.data() + seen.place(i, j));
        gauges_.insert(gauges_.end(), {f.depth, f.speed, f.pressure});
    }
}

template <class Real>
std::vector<Layers> HazardMaps::resting(const Simulation<Real, 3>& sim, const PlanColumns& seen) const {
    std::vector<Layers> layers(seen.all(), 0);
    sim.find_layers(seen, layers);
    comm_.unite(layers);
    for (std::int64_t j = 0; j < seen.count[1]; ++j)
        for (std::int64_t i = 0; i < seen.count[0]; ++i) {
            Layers& l = layers[static_cast<std::size_t>(i + seen.count[0] * j)];
            l = resting_layers(l, rise_[static_cast<std::size_t>(seen.first[0] + i + size_[0] * (seen.first[1] + j))]);
        }
    return layers;
}

template <class Real>
void HazardMaps::sample(const Simulation<Real, 3>& sim) {
    PlanColumns seen = columns_of(sim);
    std::vector<double> floor;
    for (std::int64_t j = 0; j < seen.count[1]; ++j) {
        const auto row = floor_.begin() + seen.first[0] + size_[0] * (seen.first[1] + j);
        floor.insert(floor.end(), row, row + seen.count[0]);
    }
    seen.floor = floor.data();
    const std::vector<Layers> layers = resting(sim, seen);
    seen.resting = layers.data();
    std::vector<std::int64_t> sums(seen.all_sums(), 0);
    const double v = std::sqrt(comm_.max(sim.sum_columns(seen, sums)));
    comm_.sum(sums);
    const double time = sim.clock().time;
    take(time, seen, sums);
    observe_gauges(seen, sums);
    const double g = std::hypot(scene_.gravity[0], scene_.gravity[1], scene_.gravity[2]);
    const double way = 0.5 * scene_.hazard.cell;  // 2 way / (v + sqrt(v^2 + 2 g way)) has no cancellation
    const double root = v + std::sqrt(v * v + 2 * g * way);
    next_ = root > 0 ? time + 2 * way / root : std::numeric_limits<double>::max();
}

double HazardMaps::value_of(int map, std::int64_t i, std::int64_t j) const {
    const Column& c = columns_[static_cast<std::size_t>(i + size_[0] * j)];
    if (map < maps) return c[static_cast<std::size_t>(map)];
    const double middle[2] = {static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5};
    Vec<double, 3> x = zero_vec<double, 3>();
    for (std::size_t a = 0; a < 2; ++a)
        x[static_cast<int>(a)] = std::min(scene_.min[a] + middle[a] * scene_.hazard.cell, scene_.max[a]);
    const auto slope = ground_at<3>(scene_.structures[0].ground->table.data(), x).slope;
    return c[map == max_thickness ? max_depth : deposit] / std::sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
}

std::string HazardMaps::text_of(int map) const {
    const double a = scene_.hazard.cell;
    std::string text = fmt::format("ncols {}\nnrows {}\nxllcorner {:.10g}\nyllcorner {:.10g}\ncellsize {:.10g}\n",
                                   size_[0], size_[1], scene_.min[0], scene_.min[1], a);
    text += fmt::format("NODATA_value {}\n", never);
    for (std::int64_t j = size_[1] - 1; j >= 0; --j)
        for (std::int64_t i = 0; i < size_[0]; ++i)
            text += fmt::format("{:.6g}{}", value_of(map, i, j), i + 1 < size_[0] ? ' ' : '\n');
    return text;
}

/// As GeoTIFF.
std::string HazardMaps::image_of(int map) const {
    static constexpr const char* units[files] = {"m", "m/s", "Pa", "m3/s2", "s", "m", "m", "m"};
    MapImage image{size_,
                   {scene_.min[0], scene_.min[1]},
                   scene_.hazard.cell,
                   scene_.structures[0].ground->crs,
                   hazard_map_names()[static_cast<std::size_t>(map)],
                   units[map],
                   never,
                   {}};
    for (std::int64_t j = size_[1] - 1; j >= 0; --j)
        for (std::int64_t i = 0; i < size_[0]; ++i) image.values.push_back(static_cast<float>(value_of(map, i, j)));
    return geotiff_bytes(image);
}

std::string HazardMaps::outline() const {
    std::vector<bool> reached;
    for (const Column& c : columns_) reached.push_back(c[max_depth] >= scene_.hazard.threshold);
    const auto polygons = outline_of(reached, size_, {scene_.min[0], scene_.min[1]}, scene_.hazard.cell);
    return has_gdal() ? outline_bytes(polygons, scene_.structures[0].ground->crs, scene_.hazard.threshold, {})
                      : outline_json(polygons, scene_.hazard.threshold);
}

void HazardMaps::write(const std::string& directory) const {
    comm_.agree_no_error<MachineError>(message_of([&] {
        if (!comm_.is_root()) return;
        const std::filesystem::path folder = std::filesystem::path(directory) / "maps";
        std::filesystem::create_directories(folder);
        for (int map = 0; map < files; ++map) {
            const std::string& name = hazard_map_names()[static_cast<std::size_t>(map)];
            const auto& wanted = scene_.hazard.maps;
            if (std::find(wanted.begin(), wanted.end(), name) != wanted.end())
                replace_file((folder / (name + (has_gdal() ? ".tif" : ".asc"))).string(),
                             has_gdal() ? image_of(map) : text_of(map));
        }
        replace_file((folder / (has_gdal() ? "outline.gpkg" : "outline.geojson")).string(), outline());
    }));
}

std::vector<double> HazardMaps::stored() const {
    std::vector<double> all{next_};
    for (std::size_t k = 0; k < columns_.size(); ++k) {
        if (columns_[k][max_depth] == 0) continue;
        all.push_back(static_cast<double>(k));
        all.insert(all.end(), columns_[k].begin(), columns_[k].end());
    }
    return all;
}

bool HazardMaps::restore(const std::vector<double>& all) {
    if (all.size() % (maps + 1) != 1 || !std::all_of(all.begin(), all.end(), [](double x) { return std::isfinite(x); }))
        return false;
    next_ = all[0];
    for (std::size_t at = 1; at < all.size(); at += maps + 1) {
        if (!(all[at] >= 0 && all[at] < static_cast<double>(columns_.size()))) return false;
        std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(at + 1), +maps,
                    columns_[static_cast<std::size_t>(all[at])].begin());
    }
    return true;
}

template void HazardMaps::sample(const Simulation<float, 3>&);
template void HazardMaps::sample(const Simulation<double, 3>&);

}  // namespace moraine
