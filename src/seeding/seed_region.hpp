#pragma once
// Where the particles of a box, polygon or sphere are before jitter: points of a lattice, cell centred,
//
//   x_a = origin_a + (first_a + i + 1/2) spacing_a,   i = 0 .. count_a - 1
//
// and inside the body. A box stretches its lattice to fit (every point is inside, the volume is exact);
// the others take that of the domain's corner with h / particles_per_cell.

#include <array>
#include <cstdint>

#include "core/scene_spec.hpp"

namespace moraine {

struct Lattice {
    Triple origin{};
    Triple spacing{1, 1, 1};
    std::array<double, 3> first{};
    std::array<std::int64_t, 3> count{1, 1, 1};  ///< 1 along an axis that the scene has not

    double place(std::size_t axis, std::int64_t i) const {
        return origin[axis] + (first[axis] + static_cast<double>(i) + 0.5) * spacing[axis];
    }
};

/// Smallest box around a body that is not a table; of a layer or an inflow one that holds it.
struct Extent {
    Triple lower{}, upper{};
};

Extent extent_of(const BodySpec& body, int dimensions);

/// Exact volume, in 2-D area [m3, m2].
double measure_of(const BodySpec& body, int dimensions);

/// Whether a place in plan is in the body's polygon; an edge owns its lower end.
bool is_in_polygon(const BodySpec& body, double x, double y);

/// Strictly inside, up to rounding; tables and inflows have no inside.
bool is_inside(const BodySpec& body, int dimensions, const Triple& x);

Lattice lattice_of(const Scene& scene, const BodySpec& body);

}  // namespace moraine
