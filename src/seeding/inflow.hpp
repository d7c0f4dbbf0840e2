#pragma once
// An inflow: soil that comes in over a line in plan, to its left, by a hydrograph of discharge Q and speed v.
//
//   s(t) = integral of v,   V(t) = integral of Q,   both linear between the rows of the table
//
// The soil comes in layers of the thickness D = h / particles_per_cell along its way: layer k is there when s has gone
// (k + 1) D, at t_k, and holds V(t_k) - V(t_k-1), so that no volume is lost or made; the last one ends with the table.
// Its particles stand in columns along the line, side by side on the ground and normal to it, as many in each as the
// layer is deep in their spacing, V_k / (L D), and at least one; L: length of the line over the ground. They go along
// the ground, across the line. A step that ends a little later than t_k places the layer where it would have come to.

#include <array>
#include <cstdint>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

class Inflow {
  public:
    /// Of a body that is an inflow. Both must outlive it.
    Inflow(const Scene& scene, const BodySpec& body);

    std::int64_t layers() const { return static_cast<std::int64_t>(layers_.size()); }
    /// Particles in layers [first, last).
    std::int64_t count(std::int64_t first, std::int64_t last) const;
    /// When layer k is in [s].
    double time(std::int64_t k) const { return layers_[static_cast<std::size_t>(k)].time; }
    /// Of all layers [m3].
    double volume() const { return volume_; }
    /// Depth of the deepest layer [m].
    double deepest() const;

    /// Calls f(number of the particle in the body, x [m], V_p [m3], velocity [m/s]) for layer k at time t >= t_k.
    template <class F>
    void each(std::int64_t k, double t, const F& f) const {
        const LayerOf& layer = layers_[static_cast<std::size_t>(k)];
        const double ahead = way_at(t) - layer.way + 0.5 * layer.thickness;
        std::int64_t number = layer.first;
        for (const Column& column : columns_) {
            const Foot foot = foot_of(column, ahead);
            const Triple velocity{layer.speed * foot.along[0], layer.speed * foot.along[1],
                                  layer.speed * foot.along[2]};
            for (std::int64_t j = 0; j < layer.particles; ++j, ++number) {
                const double up = (static_cast<double>(j) + 0.5) * layer.depth / static_cast<double>(layer.particles);
                f(number,
                  Triple{foot.x[0] + up * foot.normal[0], foot.x[1] + up * foot.normal[1],
                         foot.x[2] + up * foot.normal[2]},
                  layer.volume * column.share / static_cast<double>(layer.particles), velocity);
            }
        }
    }

  private:
    struct LayerOf {
        double time, way, thickness;    ///< t_k [s], s there and D [m]
        double volume, depth, speed;    ///< [m3, m, m/s]
        std::int64_t first, particles;  ///< number of its first particle; particles of a column
    };
    struct Column {
        std::array<double, 2> x, across;  ///< on the line [m]; to its left, unit
        double share;                     ///< of the line's length over the ground
    };
    struct Foot {
        Triple x, normal, along;  ///< on the ground [m]; units
    };

    double way_at(double t) const { return integral_at(speed_, ways_, t); }
    double volume_at(double t) const { return integral_at(discharge_, volumes_, t); }
    double integral_at(const std::vector<double>& rate, const std::vector<double>& sums, double t) const;
    double time_at(double way) const;
    double speed_at(double t) const;
    std::size_t row_at(double t) const;
    Foot foot_of(const Column& column, double ahead) const;
    void place_columns(double spacing);
    void cut_layers(double thickness, double spacing, double end);

    const BodySpec& body_;
    std::vector<double> time_, discharge_, speed_, ways_, volumes_;  ///< rows of the table, s and V at them
    std::vector<Column> columns_;
    std::vector<LayerOf> layers_;
    double length_ = 0, volume_ = 0;  ///< L [m]; [m3]
};

/// The largest depth that the table of an inflow has, however long a run lasts: discharge over speed and length of the
/// line in plan [m].
double peak_depth(const BodySpec& body);

}  // namespace moraine
