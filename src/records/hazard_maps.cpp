#include "records/hazard_maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "core/ground.hpp"
#include "io/disk_file.hpp"
#include "records/outline.hpp"
#include "scene/scene_keys.hpp"
#include "simulation/diagnostics.hpp"

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
}

std::int64_t HazardMaps::column_along(std::size_t axis, double x) const {
    const double at = std::floor((x - scene_.min[axis]) / scene_.hazard.cell);
    return static_cast<std::int64_t>(std::clamp(at, 0.0, static_cast<double>(size_[axis] - 1)));
}

/// Columns under the occupied blocks of all ranks.
template <class Real>
HazardMaps::Window HazardMaps::window_of(const Simulation<Real, 3>& sim) const {
    constexpr double far = 1e300;
    double low[2] = {far, far}, high[2] = {-far, -far};
    sim.each_piece({"position"}, [&](const SharePiece<Real, 3>& piece) {
        for (int b = piece.begin; b < piece.end; ++b)
            for (int a = 0; a < 2 && !piece.slots(b).empty(); ++a) {
                const double at =
                    4.0 * piece.tables.position[static_cast<std::size_t>(b)][a] - sim.method().stencil.offset();
                low[a] = std::min(low[a], at), high[a] = std::max(high[a], at + 4);
            }
    });
    Window w{};
    for (std::size_t a = 0; a < 2; ++a) {
        const double from = comm_.min(low[a]), to = comm_.max(high[a]);
        if (!(from < to)) continue;  // all have left
        w.first[a] = column_along(a, scene_.min[a] + from * scene_.cell);
        w.size[a] = column_along(a, scene_.min[a] + to * scene_.cell) - w.first[a] + 1;
    }
    return w;
}

/// Adds this rank's particles. Returns the largest of their speeds [m/s].
template <class Real>
double HazardMaps::add_columns(const Simulation<Real, 3>& sim, const Window& window,
                               std::vector<std::int64_t>& sums) const {
    double fastest = 0;
    const auto add = [&](std::size_t at, double value) {
        const auto whole = static_cast<std::int64_t>(std::llround(std::clamp(value, -9e15, 9e15)));
#pragma omp atomic
        sums[at] += whole;
    };
    sim.each_piece({"position", "volume", "mass", "velocity"}, [&](const SharePiece<Real, 3>& piece) {
#pragma omp parallel for schedule(dynamic, 64) reduction(max : fastest)
        for (int b = piece.begin; b < piece.end; ++b)
            for (std::uint32_t s : piece.slots(b)) {
                const std::array<double, 3> x = place_of(sim, piece, b, s);
                const std::int64_t i = column_along(0, x[0]) - window.first[0];
                const std::int64_t j = column_along(1, x[1]) - window.first[1];
                const std::size_t at = Sums::count * static_cast<std::size_t>(i + window.size[0] * j);
                const auto m = static_cast<double>(piece.p.mass[s]);
                add(at, static_cast<double>(piece.p.volume[s]) / volume_unit_);
                add(at + 1, m / mass_unit_);
                double square = 0;
                for (int a = 0; a < 3; ++a) {
                    const auto v = static_cast<double>(piece.p.velocity[s][a]);
                    square += v * v;
                    add(at + 2 + static_cast<std::size_t>(a), m * v / momentum_unit_);
                }
                fastest = std::max(fastest, square);
            }
    });
    return std::sqrt(fastest);
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

void HazardMaps::take(double time, const Window& window, const std::vector<std::int64_t>& sums) {
    for (Column& c : columns_) c[deposit] = 0;
    for (std::int64_t j = 0; j < window.size[1]; ++j)
        for (std::int64_t i = 0; i < window.size[0]; ++i) {
            const Flow f = flow_of(sums.data() + Sums::count * (i + window.size[0] * j));
            if (f.depth == 0) continue;
            Column& c = columns_[static_cast<std::size_t>(window.first[0] + i + size_[0] * (window.first[1] + j))];
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

void HazardMaps::observe_gauges(const Window& window, const std::vector<std::int64_t>& sums) {
    gauges_.clear();
    for (const GaugeSpec& gauge : scene_.hazard.gauges) {
        const std::int64_t i = column_along(0, gauge.x) - window.first[0];
        const std::int64_t j = column_along(1, gauge.y) - window.first[1];
        Flow f;
        if (i >= 0 && j >= 0 && i < window.size[0] && j < window.size[1])
            f = flow_of(sums.data() + Sums::count * (i + window.size[0] * j));
        gauges_.insert(gauges_.end(), {f.depth, f.speed, f.pressure});
    }
}

template <class Real>
void HazardMaps::sample(const Simulation<Real, 3>& sim) {
    const Window window = window_of(sim);
    std::vector<std::int64_t> sums(Sums::count * window.columns(), 0);
    const double v = comm_.max(add_columns(sim, window, sums));
    comm_.sum(sums);
    const double time = sim.clock().time;
    take(time, window, sums);
    observe_gauges(window, sums);
    const double g = std::hypot(scene_.gravity[0], scene_.gravity[1], scene_.gravity[2]);
    const double way = 0.5 * scene_.hazard.cell;  // 2 way / (v + sqrt(v^2 + 2 g way)) has no cancellation
    const double root = v + std::sqrt(v * v + 2 * g * way);
    next_ = root > 0 ? time + 2 * way / root : std::numeric_limits<double>::max();
}

std::string HazardMaps::text_of(int map) const {
    const double a = scene_.hazard.cell;
    std::string text = fmt::format("ncols {}\nnrows {}\nxllcorner {:.10g}\nyllcorner {:.10g}\ncellsize {:.10g}\n",
                                   size_[0], size_[1], scene_.min[0], scene_.min[1], a);
    text += fmt::format("NODATA_value {}\n", never);
    for (std::int64_t j = size_[1] - 1; j >= 0; --j)
        for (std::int64_t i = 0; i < size_[0]; ++i)
            text += fmt::format("{:.6g}{}",
                                columns_[static_cast<std::size_t>(i + size_[0] * j)][static_cast<std::size_t>(map)],
                                i + 1 < size_[0] ? ' ' : '\n');
    return text;
}

/// As GeoTIFF.
std::string HazardMaps::image_of(int map) const {
    static constexpr const char* units[maps] = {"m", "m/s", "Pa", "m3/s2", "s", "m"};
    MapImage image{size_,
                   {scene_.min[0], scene_.min[1]},
                   scene_.hazard.cell,
                   scene_.structures[0].ground->crs,
                   hazard_map_names()[static_cast<std::size_t>(map)],
                   units[map],
                   never,
                   {}};
    for (std::int64_t j = size_[1] - 1; j >= 0; --j)
        for (std::int64_t i = 0; i < size_[0]; ++i)
            image.values.push_back(static_cast<float>(
                columns_[static_cast<std::size_t>(i + size_[0] * j)][static_cast<std::size_t>(map)]));
    return geotiff_bytes(image);
}

std::string HazardMaps::outline() const {
    std::vector<bool> reached;
    for (const Column& c : columns_) reached.push_back(c[max_depth] >= scene_.hazard.threshold);
    const auto polygons = outline_of(reached, size_, {scene_.min[0], scene_.min[1]}, scene_.hazard.cell);
    return has_gdal() ? outline_bytes(polygons, scene_.structures[0].ground->crs, scene_.hazard.threshold)
                      : outline_json(polygons, scene_.hazard.threshold);
}

void HazardMaps::write(const std::string& directory) const {
    comm_.agree_no_error<MachineError>(message_of([&] {
        if (!comm_.is_root()) return;
        const std::filesystem::path folder = std::filesystem::path(directory) / "maps";
        std::filesystem::create_directories(folder);
        for (int map = 0; map < maps; ++map) {
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
