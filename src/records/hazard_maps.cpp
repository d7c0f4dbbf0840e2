#include "records/hazard_maps.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/data/morton.hpp"
#include "core/structures/ground.hpp"

namespace moraine {
namespace {

constexpr double never = -9999;  ///< NODATA of arrival

}  // namespace

HazardMaps::HazardMaps(const Scene& scene, const Comm& comm) : scene_(scene), comm_(comm) {
    const double a = scene.hazard.cell;
    const auto whole = [](double share) { return std::fabs(share - 1) < 1e-9 ? 1 : share; };
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const double origin = scene.hazard.origin[axis], narrow = (1 - 1e-9) * scene.cell / a;
        double begin = std::floor((scene.min[axis] - origin) / a + 1e-9);  // in cells of the grid
        const double low = (scene.min[axis] - origin) / a, high = (scene.max[axis] - origin) / a;
        if (begin + 1 - low < std::min(narrow, 1 - 1e-9) && high - begin > 1) begin += 1;
        size_[axis] = std::max<std::int64_t>(1, std::llround(std::ceil(high - begin - 1e-9)));
        if (size_[axis] > 1 && high - begin - static_cast<double>(size_[axis] - 1) < narrow) --size_[axis];
        corner_[axis] = origin + a * begin;
        const bool alone = size_[axis] == 1;
        first_[axis] = whole((alone ? high : begin + 1) - low);
        last_[axis] = alone ? first_[axis] : whole(high - begin - static_cast<double>(size_[axis] - 1));
    }
    double density = 0;
    for (const MaterialSpec& material : scene.materials) density = std::max(density, material.density);
    volume_unit_ = std::ldexp(a * a * scene.cell, -36);  // 2^27 cells deep fit
    mass_unit_ = density * volume_unit_;
    momentum_unit_ = 64 * mass_unit_;  // of 1 m/s
    tiles_along_ = (size_[0] + PlanColumns::edge - 1) / PlanColumns::edge;
}

/// Ground of places half a cell of the terrain model apart or closer.
HazardMaps::Tile& HazardMaps::owned_tile(std::int64_t tile) {
    const auto [found, is_new] = tiles_.try_emplace(tile);
    if (!is_new) return found->second;
    const Ground& ground = *scene_.structures[0].ground;
    const double a = scene_.hazard.cell;
    const int pieces = std::max(2, static_cast<int>(std::ceil(2 * a / ground.spacing)));
#pragma omp parallel for schedule(static)
    for (std::size_t k = 0; k < in_tile; ++k) {
        const std::array<std::int64_t, 2> index = place_of(tile, k);
        if (!is_in_map(index)) continue;
        double low = std::numeric_limits<double>::max(), high = -low;
        for (int n = 0; n < (pieces + 1) * (pieces + 1); ++n) {
            const int part[2] = {n % (pieces + 1), n / (pieces + 1)};
            Vec<double, 3> x = zero_vec<double, 3>();
            for (std::size_t b = 0; b < 2; ++b)
                x[static_cast<int>(b)] = begin(b, index[b]) + a * share(b, index[b]) * part[b] / pieces;
            const double height = ground_at<3>(ground.table.data(), x).height;
            low = std::min(low, height), high = std::max(high, height);
        }
        Column& column = found->second[k];
        column.floor = low;
        column.rise = static_cast<int>(std::min(63.0, std::floor((high - low) / scene_.cell) + 1));
    }
    return found->second;
}

template <class Real>
PlanColumns HazardMaps::columns_of(const Simulation<Real, 3>& sim) const {
    return {sim.plan_places(),
            {corner_[0], corner_[1]},
            scene_.hazard.cell,
            {size_[0], size_[1]},
            {},
            {},
            volume_unit_,
            mass_unit_,
            momentum_unit_};
}

template <class Real>
std::vector<std::int64_t> HazardMaps::tiles_under(const Simulation<Real, 3>& sim, PlanColumns& seen,
                                                  std::vector<std::int32_t>& table) const {
    const BlockCounts blocks = sim.block_counts();
    const auto each = [&](const auto& f) {
        for (Key key : blocks.key) {
            const auto at = Morton<3>::decode(key);
            std::int64_t low[2], high[2];
            for (int a = 0; a < 2; ++a) {
                const auto block = static_cast<std::int32_t>(at[static_cast<std::size_t>(a)]);
                low[a] = seen.along(a, seen.places.at(a, block, 0)) / PlanColumns::edge;
                high[a] = seen.along(a, seen.places.at(a, block, 4)) / PlanColumns::edge;
            }
            f(low, high);
        }
    };
    const std::int64_t most = std::numeric_limits<std::int64_t>::max();
    std::int64_t first[2] = {most, most}, last[2] = {-1, -1};
    each([&](const std::int64_t* low, const std::int64_t* high) {
        for (int a = 0; a < 2; ++a) first[a] = std::min(first[a], low[a]), last[a] = std::max(last[a], high[a]);
    });
    for (int a = 0; a < 2 && last[0] >= 0; ++a) seen.first[a] = first[a], seen.count[a] = last[a] - first[a] + 1;
    table.assign(seen.all_tiles(), -1);
    each([&](const std::int64_t* low, const std::int64_t* high) {
        for (std::int64_t j = low[1]; j <= high[1]; ++j)
            for (std::int64_t i = low[0]; i <= high[0]; ++i)
                table[static_cast<std::size_t>(i - first[0] + seen.count[0] * (j - first[1]))] = 0;
    });
    std::vector<std::int64_t> tiles;
    for (std::size_t t = 0; t < table.size(); ++t) {
        const auto at = static_cast<std::int64_t>(t);
        if (table[t] == 0)
            tiles.push_back(first[0] + at % seen.count[0] + tiles_along_ * (first[1] + at / seen.count[0]));
    }
    return tiles;
}

HazardMaps::Flow HazardMaps::flow_of(std::int64_t i, std::int64_t j, const std::int64_t* s) const {
    if (s[1] == 0) return {};
    const double plan = scene_.hazard.cell * scene_.hazard.cell * share(0, i) * share(1, j);
    const double volume = static_cast<double>(s[0]) * volume_unit_, depth = volume / plan;
    if (depth < scene_.hazard.threshold) return {depth, 0, 0};
    const double mass = static_cast<double>(s[1]) * mass_unit_;
    const double speed = momentum_unit_ / mass *
                         std::hypot(static_cast<double>(s[2]), static_cast<double>(s[3]), static_cast<double>(s[4]));
    return {depth, speed, mass / volume * speed * speed};
}

void HazardMaps::take(double time, const std::vector<std::int64_t>& owned, const std::vector<std::int64_t>& sums) {
    for (std::int64_t tile : deposited_)
        for (Column& c : tiles_.at(tile)) c.value[deposit] = 0;
    deposited_ = owned;
    for (std::size_t t = 0; t < owned.size(); ++t) {
        Tile& tile = owned_tile(owned[t]);
        for (std::size_t k = 0; k < in_tile; ++k) {
            const auto [i, j] = place_of(owned[t], k);
            const Flow f = flow_of(i, j, sums.data() + PlanColumns::sums * (t * in_tile + k));
            if (f.depth == 0) continue;
            std::array<double, maps>& c = tile[k].value;
            c[deposit] = f.depth;
            c[max_depth] = std::max(c[max_depth], f.depth);
            if (f.depth < scene_.hazard.threshold) continue;
            if (c[arrival] == never) c[arrival] = time;
            c[max_speed] = std::max(c[max_speed], f.speed);
            c[max_pressure] = std::max(c[max_pressure], f.pressure);
            c[max_momentum_flux] = std::max(c[max_momentum_flux], f.depth * f.speed * f.speed);
        }
    }
}

std::vector<std::string> HazardMaps::gauge_columns() const {
    std::vector<std::string> names{"step", "time_s"};
    for (const GaugeSpec& gauge : scene_.hazard.gauges)
        for (const char* what : {"depth_m", "speed_m_s", "pressure_Pa"}) names.push_back(gauge.name + "_" + what);
    return names;
}

/// Who owns a gauge's column tells all.
void HazardMaps::observe_gauges(const std::vector<std::int64_t>& owned, const std::vector<std::int64_t>& sums) {
    gauges_.clear();
    std::vector<std::int64_t> bits;
    for (const GaugeSpec& gauge : scene_.hazard.gauges) {
        const double at[2] = {gauge.x, gauge.y};
        std::int64_t index[2];
        for (std::size_t a = 0; a < 2; ++a)
            index[a] = std::clamp<std::int64_t>(
                static_cast<std::int64_t>(std::floor((at[a] - corner_[a]) / scene_.hazard.cell)), 0, size_[a] - 1);
        const std::int64_t edge = PlanColumns::edge, tile = index[0] / edge + tiles_along_ * (index[1] / edge);
        const auto found = std::lower_bound(owned.begin(), owned.end(), tile);
        Flow f;
        if (found != owned.end() && *found == tile)
            f = flow_of(index[0], index[1],
                        sums.data() + PlanColumns::sums * ((found - owned.begin()) * PlanColumns::in_tile +
                                                           edge * (index[1] % edge) + index[0] % edge));
        for (double value : {f.depth, f.speed, f.pressure}) bits.push_back(std::bit_cast<std::int64_t>(value));
    }
    comm_.sum(bits);
    for (std::int64_t value : bits) gauges_.push_back(std::bit_cast<double>(value));
}

template <class Real>
std::vector<Layers> HazardMaps::resting(const Simulation<Real, 3>& sim, const PlanTiles& tiles,
                                        const PlanColumns& seen) {
    std::vector<Layers> mine(seen.all(), 0);
    sim.answer(LayerQuery{seen, mine});
    std::vector<Layers> all = tiles.add_up(mine, 1, [](Layers& to, Layers bits) { to |= bits; });
    for (std::size_t t = 0; t < tiles.owned().size(); ++t) {
        const Tile& tile = owned_tile(tiles.owned()[t]);
        for (std::size_t k = 0; k < in_tile; ++k)
            all[t * in_tile + k] = resting_layers(all[t * in_tile + k], tile[k].rise);
    }
    return tiles.fetch(all);
}

template <class Real>
void HazardMaps::sample(const Simulation<Real, 3>& sim) {
    PlanColumns seen = columns_of(sim);
    std::vector<std::int32_t> table;
    const PlanTiles tiles(comm_, tiles_under(sim, seen, table));
    for (std::size_t t = 0; t < tiles.mine().size(); ++t) {
        const std::int64_t tile = tiles.mine()[t];
        table[static_cast<std::size_t>(tile % tiles_along_ - seen.first[0] +
                                       seen.count[0] * (tile / tiles_along_ - seen.first[1]))] =
            static_cast<std::int32_t>(t);
    }
    seen.tiles = static_cast<std::int64_t>(tiles.mine().size());
    seen.tile = table.data();
    std::vector<double> floor;
    floor.reserve(tiles.owned().size() * in_tile);
    for (std::int64_t tile : tiles.owned())
        for (const Column& column : owned_tile(tile)) floor.push_back(column.floor);
    floor = tiles.fetch(floor);
    seen.floor = floor.data();
    const std::vector<Layers> layers = resting(sim, tiles, seen);
    seen.resting = layers.data();
    std::vector<std::int64_t> sums(seen.all_sums(), 0);
    const double v = std::sqrt(comm_.max(sim.answer(ColumnQuery{seen, sums}).square_speed));
    sums = tiles.add_up(sums, PlanColumns::sums, [](std::int64_t& to, std::int64_t sum) { to += sum; });
    const double time = sim.clock().time;
    take(time, tiles.owned(), sums);
    if (!scene_.hazard.gauges.empty()) observe_gauges(tiles.owned(), sums);
    const double g = std::hypot(scene_.gravity[0], scene_.gravity[1], scene_.gravity[2]);
    const double way = 0.5 * scene_.hazard.cell;  // 2 way / (v + sqrt(v^2 + 2 g way)) has no cancellation
    const double root = v + std::sqrt(v * v + 2 * g * way);
    next_ = root > 0 ? time + 2 * way / root : std::numeric_limits<double>::max();
}

namespace {

/// Of a checkpoint: number and values of a column.
constexpr std::size_t stored_values = 7;
using StoredColumn = std::array<double, stored_values>;

}  // namespace

std::vector<double> HazardMaps::stored() const {
    static_assert(stored_values == maps + 1);
    std::vector<StoredColumn> mine;
    for (const auto& [number, tile] : tiles_)
        for (std::size_t k = 0; k < in_tile; ++k) {
            const auto& value = tile[k].value;
            if (value[max_depth] == 0) continue;
            const auto [i, j] = place_of(number, k);
            StoredColumn column{static_cast<double>(i + size_[0] * j)};
            std::copy(value.begin(), value.end(), column.begin() + 1);
            mine.push_back(column);
        }
    std::vector<std::int64_t> counts(static_cast<std::size_t>(comm_.size()), 0);
    counts[0] = static_cast<std::int64_t>(mine.size());
    std::vector<StoredColumn> columns = comm_.exchange(mine, counts);
    std::sort(columns.begin(), columns.end());
    std::vector<double> all{next_};
    for (const StoredColumn& column : columns) all.insert(all.end(), column.begin(), column.end());
    return all;
}

bool HazardMaps::restore(const std::vector<double>& all) {
    if (all.size() % stored_values != 1 || !(all[0] >= 0)) return false;
    next_ = all[0];
    const double columns = static_cast<double>(size_[0]) * static_cast<double>(size_[1]);
    double last = -1;
    for (std::size_t at = 1; at < all.size(); at += stored_values) {
        const double number = all[at];
        if (!(number > last && number < columns) || number != std::floor(number)) return false;
        last = number;
        for (std::size_t map = 0; map < maps; ++map) {
            const double value = all[at + 1 + map];
            if (!std::isfinite(value) || (value < 0 && !(map == arrival && value == never))) return false;
        }
        const auto place = static_cast<std::int64_t>(number);
        const std::int64_t edge = PlanColumns::edge, i = place % size_[0], j = place / size_[0];
        const std::int64_t tile = i / edge + tiles_along_ * (j / edge);
        if (owner_of_tile(tile, comm_.size()) != comm_.rank()) continue;
        std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(at + 1), +maps,
                    owned_tile(tile)[static_cast<std::size_t>(edge * (j % edge) + i % edge)].value.begin());
        if (deposited_.empty() || deposited_.back() != tile) deposited_.push_back(tile);
    }
    return true;
}

template void HazardMaps::sample(const Simulation<float, 3>&);
template void HazardMaps::sample(const Simulation<double, 3>&);

}  // namespace moraine
