#pragma once
// A release: a layer of thickness T normal to the ground, over a polygon in plan, draped with particles. T is constant,
// or by a raster: then a column has as many particles as it has spacings, and none where that rounds to zero.
//
//   x_p = (x, y, b + (k + 1/2) sec T / n),   k = 0 .. n - 1,   n = round(T / s),   s = h / particles_per_cell
//   V_p = f s_x s_y sec(x, y) T / n,   sec = sqrt(1 + |grad b|^2)
//   V   = integral of T sec over the polygon = sum_p V_p, which is what f is for
//
// (x, y): points of the domain's lattice in the polygon. A column is upright, as high as the layer is along z, and its
// lowest particle half a spacing from the slope, where a lattice cut by the ground would begin at random heights. So
// each particle has its volume of space over ground of any curvature; columns along the normal crowd in hollows.
//
// The integral is by cells of half the model's spacing, cut by the polygon, at their centroids.

#include <array>
#include <cstdint>
#include <vector>

#include "core/scene_spec.hpp"
#include "core/structures/ground_table.hpp"

namespace moraine {

/// Area of the ground over that in plan.
double secant_of(const GroundPoint<3>& point);

/// V [m3].
double layer_volume(const BodySpec& body);

/// T over a place in plan [m].
double layer_thickness(const BodySpec& body, double x, double y);

/// How far a place is from the ground below it along the ground's normal there [m], by which T counts.
double height_in_layer(const BodySpec& body, const Triple& x);

/// The highest place of a layer of the largest T, of places a model's spacing apart in the polygon's box [m].
double layer_top(const BodySpec& body);

class Layer {
  public:
    /// Of a body that is a layer. Goes through its columns once. Both must outlive it.
    Layer(const Scene& scene, const BodySpec& body);

    std::int64_t rows() const { return count_[1]; }
    std::int64_t count(std::int64_t first, std::int64_t last) const;

    /// Calls f(place in the lattice, x [m], V_p [m3]) for the particles of rows [first, last): lines along x.
    template <class F>
    void each(std::int64_t first, std::int64_t last, const F& f) const {
        for (std::int64_t j = first; j < last; ++j)
            for (std::int64_t i = 0; i < count_[0]; ++i) {
                const Column c = column(i, j);
                for (std::int64_t k = 0; k < c.particles; ++k) {
                    const double up = (static_cast<double>(k) + 0.5) * c.height / static_cast<double>(c.particles);
                    f(i + count_[0] * (j + count_[1] * k), Triple{c.foot[0], c.foot[1], c.foot[2] + up},
                      c.weight * share_ * (static_cast<double>(layers_) / static_cast<double>(c.particles)));
                }
            }
    }

  private:
    struct Column {
        Triple foot{};
        double height = 0;           ///< T sec [m]
        double weight = 0;           ///< sec T over the largest T
        std::int64_t particles = 0;  ///< n; 0: not in the polygon, or too thin
    };
    Column column(std::int64_t i, std::int64_t j) const;

    const BodySpec& body_;
    std::array<double, 2> first_{}, spacing_{};  ///< of the lattice in plan [m]
    std::array<std::int64_t, 2> count_{};
    double spacing_along_normal_ = 1;      ///< s [m]
    std::int64_t layers_ = 1;              ///< n of the largest T
    double share_ = 0;                     ///< V_p of level ground and the largest T [m3]
    std::vector<std::int64_t> particles_;  ///< in rows before each
};

}  // namespace moraine
