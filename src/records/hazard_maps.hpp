#pragma once
// maps/NAME.tif (.asc where there is no GDAL): what a run over terrain leaves in plan, sampled while it goes on.
//
//   depth  D = sum V_p / A          vertical: of the particles over a map cell of side a that do not fly
//   speed  w = |sum m v| / sum m    of the mean of these, its vertical part included
//   max_depth, max_speed; max_pressure: (sum m / sum V) w^2 [Pa]; max_momentum_flux: D w^2 [m3/s2];
//   arrival: time of the first sample with D >= threshold [s]; deposit: D of the last sample [m]
//   max_thickness, deposit_thickness: max_depth and deposit times the cosine of the ground's slope in the middle of the
//   cell [m]: normal to the ground
//
// A is a^2, at the domain's upper ends the part of the cell inside of the domain. What is left there and narrower than
// h would hold single particles: the last column has it too.
//
// A particle flies over two empty layers of h: from a cell or two above the highest ground of its map cell on, layers
// of the column are gone through upwards, and what is above the first two in turn that hold nobody is no depth
// (core/data/plan_samples.hpp). What lies on a structure that high flies too.
//
// A column tells speed, pressure and flux while D >= threshold. Samples come so close that what moves now and falls
// freely goes half a map cell between two, and at the end: tau with v tau + g tau^2 / 2 = a / 2. The sums are of whole
// numbers, and those of a column come together at its owner before anything is compared: one answer on any number of
// ranks. Columns are kept in tiles (records/plan_tiles.hpp), which exist where soil has been, each on one rank. A
// checkpoint keeps the maps. The files are written with checkpoints and at the end, and beside them the outline of the
// columns whose largest depth has reached the threshold (records/outline.hpp).

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "io/gis_file.hpp"
#include "records/plan_tiles.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

class HazardMaps {
  public:
    /// comm and scene must outlive it.
    HazardMaps(const Scene& scene, const Comm& comm);

    /// Whether a sample is to be taken now. The same on all ranks.
    bool is_due(double time) const { return time >= next_; }
    double next_look() const { return next_; }  ///< from when on one is [s]
    /// Takes a sample. Binned state only. Collective.
    template <class Real>
    void sample(const Simulation<Real, 3>& sim);

    /// Tries what write() will need, before the first step: InputError where the folder cannot be. Rank 0 gets what to
    /// warn of: where GDAL cannot write here, the maps will be .asc and .geojson. Collective.
    std::string prepare(const std::string& directory);
    /// The files into the directory's folder maps, with words about the run. Rank 0 writes. Collective; throws
    /// MachineError.
    void write(const std::string& directory, const MapTags& tags) const;

    /// gauges.csv: step, time, and of each gauge's column depth, speed and pressure at the last sample.
    std::vector<std::string> gauge_columns() const;
    const std::vector<double>& gauge_values() const { return gauges_; }

    /// For a checkpoint: rank 0 gets all of it. Collective.
    std::vector<double> stored() const;
    /// Returns whether `all` can be what stored() gave in such a scene. The same `all` on all ranks.
    bool restore(const std::vector<double>& all);

  private:
    /// The first `maps` are kept, those behind them follow from these.
    enum Map {
        max_depth,
        max_speed,
        max_pressure,
        max_momentum_flux,
        arrival,
        deposit,
        maps,
        max_thickness = maps,
        deposit_thickness,
        files
    };
    static constexpr std::size_t in_tile = PlanColumns::in_tile;

    /// One column of a map.
    struct Column {
        std::array<double, maps> value{0, 0, 0, 0, -9999, 0};
        double floor = 0;  ///< lowest ground [m]
        int rise = 0;      ///< layer of its highest ground, and one more
    };
    static_assert(sizeof(Column) == PlanColumns::kept_bytes);
    using Tile = std::array<Column, in_tile>;
    /// What a tile holds of one map.
    struct TileValues {
        std::int64_t tile;
        std::array<double, in_tile> value;
    };

    template <class Real>
    PlanColumns columns_of(const Simulation<Real, 3>& sim) const;
    /// Marks the tiles over this rank's blocks and returns their numbers.
    template <class Real>
    std::vector<std::int64_t> tiles_under(const Simulation<Real, 3>& sim, PlanColumns& seen,
                                          std::vector<std::int32_t>& table) const;
    /// Column k of a tile.
    std::array<std::int64_t, 2> place_of(std::int64_t tile, std::size_t k) const {
        const auto within = static_cast<std::int64_t>(k);
        return {tile % tiles_along_ * PlanColumns::edge + within % PlanColumns::edge,
                tile / tiles_along_ * PlanColumns::edge + within / PlanColumns::edge};
    }
    bool is_in_map(const std::array<std::int64_t, 2>& at) const { return at[0] < size_[0] && at[1] < size_[1]; }
    /// An owned tile; new ones find their ground.
    Tile& owned_tile(std::int64_t tile);
    /// The layers of each column of this rank's tiles that do not fly. Collective.
    template <class Real>
    std::vector<Layers> resting(const Simulation<Real, 3>& sim, const PlanTiles& tiles, const PlanColumns& seen);
    /// Of one column now: a speed only where it is deep enough to tell one.
    struct Flow {
        double depth = 0, speed = 0, pressure = 0;
    };
    Flow flow_of(std::int64_t i, std::int64_t j, const std::int64_t* sums) const;
    /// The side of a column along an axis [a].
    double share(std::size_t axis, std::int64_t index) const {
        return index == 0 ? first_[axis] : index + 1 < size_[axis] ? 1 : last_[axis];
    }
    /// Where a column's part of the domain begins [m].
    double begin(std::size_t axis, std::int64_t index) const {
        return index == 0 ? scene_.min[axis] : corner_[axis] + scene_.hazard.cell * static_cast<double>(index);
    }
    void observe_gauges(const std::vector<std::int64_t>& owned, const std::vector<std::int64_t>& sums);
    void take(double time, const std::vector<std::int64_t>& owned, const std::vector<std::int64_t>& sums);
    // hazard_map_files.cpp
    /// Of a column, as it is written.
    double value_of(int map, const std::array<std::int64_t, 2>& at, const Column& column) const;
    /// All tiles at rank 0, ascending. Collective.
    std::vector<TileValues> gathered(int map) const;
    template <class T>
    void fill_row(const std::vector<TileValues>& tiles, std::int64_t j, bool times, T* row) const;
    void write_text(const std::string& path, int map, const std::vector<TileValues>& tiles) const;
    std::string image_of(int map, const std::vector<TileValues>& tiles, const MapTags& tags) const;
    std::string outline(const std::vector<TileValues>& deepest, const MapTags& tags) const;
    static double most_of(const std::vector<TileValues>& tiles);

    const Scene& scene_;
    const Comm& comm_;
    std::array<std::int64_t, 2> size_{};  ///< columns along x and y
    std::array<double, 2> corner_{};      ///< of the map, on the grid of hazard.origin [m]
    std::array<double, 2> first_{};       ///< sides of the first column within the domain [a]
    std::array<double, 2> last_{};        ///< and of the last
    double volume_unit_ = 1, mass_unit_ = 1, momentum_unit_ = 1;
    std::int64_t tiles_along_ = 1;         ///< x
    std::map<std::int64_t, Tile> tiles_;   ///< that this rank owns
    std::vector<std::int64_t> deposited_;  ///< those of the last sample
    std::vector<double> gauges_;           ///< the last observation
    bool by_gdal_ = has_gdal();            ///< files of its formats
    double next_ = 0;                      ///< time of the next sample [s]
};

}  // namespace moraine
