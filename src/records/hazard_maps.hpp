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
// (core/plan_samples.hpp). What lies on a structure that high flies too.
//
// A column tells speed, pressure and flux while D >= threshold. Samples come so close that what moves now and falls
// freely goes half a map cell between two, and at the end: tau with v tau + g tau^2 / 2 = a / 2. The sums are of whole
// numbers, and ranks that share a column add theirs before anything is compared: one answer on any number of ranks. A
// checkpoint keeps the maps. The files are written with checkpoints and at the end, and beside them the outline of the
// columns whose largest depth has reached the threshold (records/outline.hpp).

#include <array>
#include <cstdint>
#include <string>
#include <vector>

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

    /// The files into the directory's folder maps. Rank 0 writes. Collective; throws MachineError.
    void write(const std::string& directory) const;

    /// gauges.csv: step, time, and of each gauge's column depth, speed and pressure at the last sample.
    std::vector<std::string> gauge_columns() const;
    const std::vector<double>& gauge_values() const { return gauges_; }

    /// For a checkpoint; the same on all ranks.
    std::vector<double> stored() const;
    /// Returns whether `all` can be what stored() gave in such a scene.
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
    using Column = std::array<double, maps>;

    template <class Real>
    PlanColumns columns_of(const Simulation<Real, 3>& sim) const;
    void find_ground();
    /// The layers of each column that do not fly. Collective.
    template <class Real>
    std::vector<Layers> resting(const Simulation<Real, 3>& sim, const PlanColumns& seen) const;
    /// Of one column now: a speed only where it is deep enough to tell one.
    struct Flow {
        double depth = 0, speed = 0, pressure = 0;
    };
    Flow flow_of(std::int64_t i, std::int64_t j, const std::int64_t* sums) const;
    /// The side of a column along an axis [a].
    double share(std::size_t axis, std::int64_t index) const { return index + 1 < size_[axis] ? 1 : last_[axis]; }
    void observe_gauges(const PlanColumns& seen, const std::vector<std::int64_t>& sums);
    void take(double time, const PlanColumns& seen, const std::vector<std::int64_t>& sums);
    /// Of a column, as it is written.
    double value_of(int map, std::int64_t i, std::int64_t j) const;
    std::string text_of(int map) const;
    std::string image_of(int map) const;
    std::string outline() const;

    const Scene& scene_;
    const Comm& comm_;
    std::array<std::int64_t, 2> size_{};  ///< columns along x and y
    std::array<double, 2> last_{};        ///< side of the last column along each [a]
    double volume_unit_ = 1, mass_unit_ = 1, momentum_unit_ = 1;
    std::vector<Column> columns_;  ///< x fastest, y rising
    std::vector<double> floor_;    ///< lowest ground of each column [m]
    std::vector<int> rise_;        ///< layer of its highest ground, and one more
    std::vector<double> gauges_;   ///< the last observation
    double next_ = 0;              ///< time of the next sample [s]
};

}  // namespace moraine
