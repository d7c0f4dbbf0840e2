#include "seeding/seed_region.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/structures/ground.hpp"
#include "seeding/seed_layer.hpp"

namespace moraine {
namespace {

/// Twice the signed area, by the shoelace formula about the first corner.
double twice_area(const BodySpec& body) {
    double sum = 0;
    const std::size_t n = body.points.size();
    const auto& o = body.points[0];
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const auto& a = body.points[i];
        const auto& b = body.points[i + 1];
        sum += (a[0] - o[0]) * (b[1] - o[1]) - (b[0] - o[0]) * (a[1] - o[1]);
    }
    return sum;
}

}  // namespace

/// Even-odd rule; an edge owns its lower end, so a corner counts once.
bool is_in_polygon(const BodySpec& body, double x, double y) {
    bool inside = false;
    const std::size_t n = body.points.size();
    for (std::size_t i = 0, j = n - 1; i < n; j = i++) {
        const auto& a = body.points[i];
        const auto& b = body.points[j];
        if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1])) inside = !inside;
    }
    return inside;
}

Extent extent_of(const BodySpec& body, int dimensions) {
    Extent e{body.min, body.max};
    if (body.shape == BodyShape::sphere)
        for (std::size_t a = 0; a < static_cast<std::size_t>(dimensions); ++a)
            e.lower[a] = body.center[a] - body.radius, e.upper[a] = body.center[a] + body.radius;
    const bool draped = body.shape == BodyShape::layer || body.shape == BodyShape::inflow;
    if (body.shape == BodyShape::polygon || draped)
        for (std::size_t a = 0; a < 2; ++a) {
            const auto [low, high] = std::minmax_element(body.points.begin(), body.points.end(),
                                                         [a](const auto& p, const auto& q) { return p[a] < q[a]; });
            e.lower[a] = (*low)[a], e.upper[a] = (*high)[a];
        }
    if (draped)
        for (std::size_t a = 0; a < 3; ++a) {
            if (a == 2) e.lower[2] = body.ground->table[2][0], e.upper[2] = body.ground->table[2][1];
            e.lower[a] -= a == 2 ? 0 : body.thickness, e.upper[a] += body.thickness;
        }
    return e;
}

double measure_of(const BodySpec& body, int dimensions) {
    if (body.shape == BodyShape::sphere) {
        const double disk = std::numbers::pi * body.radius * body.radius;
        return dimensions == 2 ? disk : disk * body.radius * 4 / 3;
    }
    if (body.shape == BodyShape::layer) return layer_volume(body);
    if (body.shape == BodyShape::inflow) return body.hydrograph->volume;
    const double height = dimensions == 2 ? 1 : body.max[2] - body.min[2];
    if (body.shape == BodyShape::polygon) return 0.5 * std::abs(twice_area(body)) * height;
    return (body.max[0] - body.min[0]) * (body.max[1] - body.min[1]) * height;
}

namespace {

/// Over the polygon, and no further off the ground than the layer is thick.
bool is_in_layer(const BodySpec& body, const Triple& x) {
    const double height = height_in_layer(body, x);
    return height > 0 && height < layer_thickness(body, x[0], x[1]) && is_in_polygon(body, x[0], x[1]);
}

}  // namespace

bool is_inside(const BodySpec& body, int dimensions, const Triple& x) {
    if (body.shape == BodyShape::layer) return is_in_layer(body, x);
    const bool within_height = dimensions == 2 || (x[2] > body.min[2] && x[2] < body.max[2]);
    if (body.shape == BodyShape::polygon) return within_height && is_in_polygon(body, x[0], x[1]);
    if (body.shape == BodyShape::box)
        return within_height && x[0] > body.min[0] && x[0] < body.max[0] && x[1] > body.min[1] && x[1] < body.max[1];
    if (body.shape == BodyShape::table || body.shape == BodyShape::inflow) return false;
    double square = 0;
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimensions); ++a)
        square += (x[a] - body.center[a]) * (x[a] - body.center[a]);
    return square < body.radius * body.radius;
}

Lattice lattice_of(const Scene& scene, const BodySpec& body) {
    Lattice lattice;
    const Extent e = extent_of(body, scene.dimensions);
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        const double spacing = scene.cell / body.particles_per_cell[a];
        const double length = e.upper[a] - e.lower[a];
        if (body.shape == BodyShape::box) {
            lattice.count[a] = std::max<std::int64_t>(1, std::llround(length / spacing));
            lattice.origin[a] = e.lower[a];
            lattice.spacing[a] = length / static_cast<double>(lattice.count[a]);
        } else {
            lattice.origin[a] = scene.min[a];
            lattice.spacing[a] = spacing;
            lattice.first[a] = std::floor((e.lower[a] - scene.min[a]) / spacing);
            const double last = std::ceil((e.upper[a] - scene.min[a]) / spacing);
            lattice.count[a] = std::max<std::int64_t>(1, std::llround(last - lattice.first[a]));
        }
    }
    return lattice;
}

}  // namespace moraine
