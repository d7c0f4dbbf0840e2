#include "seeding/traction_place.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "core/particles/make_traction.hpp"
#include "seeding/seed.hpp"
#include "seeding/seed_region.hpp"

namespace moraine {
namespace {

constexpr double none = std::numeric_limits<double>::infinity();
constexpr double parallel = 1 - 1e-9;  // cosine

/// Axis that the normal is along, or -1.
int axis_of(const Triple& normal) {
    for (std::size_t a = 0; a < 3; ++a)
        if (std::fabs(normal[a]) > parallel) return static_cast<int>(a);
    return -1;
}

/// Along an axis, to a face of the box or an end of the prism.
double way_to_face(const BodySpec& body, const Triple& normal, const Triple& x) {
    const auto a = static_cast<std::size_t>(axis_of(normal));
    return normal[a] > 0 ? body.max[a] - x[a] : x[a] - body.min[a];
}

/// To the last edge of the polygon that the line crosses, if that faces along the normal.
double way_to_edge(const BodySpec& body, const Triple& m, const Triple& x) {
    double way = -1, cosine = 0;
    const std::size_t n = body.points.size();
    for (std::size_t i = 0, j = n - 1; i < n; j = i++) {
        const double ax = body.points[j][0] - x[0], ay = body.points[j][1] - x[1];
        const double bx = body.points[i][0] - x[0], by = body.points[i][1] - x[1];
        const double a = m[0] * ay - m[1] * ax, b = m[0] * by - m[1] * bx;  // to the left of the line
        if ((a > 0) == (b > 0)) continue;
        const double t = a / (a - b), along = (ax + t * (bx - ax)) * m[0] + (ay + t * (by - ay)) * m[1];
        if (along <= way) continue;
        way = along;
        cosine = std::fabs((by - ay) * m[0] - (bx - ax) * m[1]) / std::hypot(bx - ax, by - ay);
    }
    return way >= 0 && cosine > parallel ? way : none;
}

}  // namespace

double load_place(const Scene& scene, const TractionSpec& traction, int body, const Triple& x) {
    if (body != traction.body) return 0;
    const BodySpec& spec = scene.bodies[static_cast<std::size_t>(body)];
    const bool face = spec.shape == BodyShape::box || axis_of(traction.normal) == 2;
    const double d = face ? way_to_face(spec, traction.normal, x) : way_to_edge(spec, traction.normal, x);
    const double place = load_place_at(traction, d);
    if (!(place > 0)) return 0;
    BodySpec area;
    area.points = traction.area;
    const bool within =
        traction.area.empty() || is_in_polygon(area, x[0] + d * traction.normal[0], x[1] + d * traction.normal[1]);
    return within ? place : 0;
}

double line_spacing(const Scene& scene, const TractionSpec& traction) {
    const Lattice lattice = lattice_of(scene, scene.bodies[static_cast<std::size_t>(traction.body)]);
    if (const int axis = axis_of(traction.normal); axis >= 0) return lattice.spacing[static_cast<std::size_t>(axis)];
    double volume = 1;
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) volume *= lattice.spacing[a];
    return std::pow(volume, 1.0 / scene.dimensions);
}

LoadedPart loaded_part(const Scene& scene, const TractionSpec& traction) {
    const BodySpec& body = scene.bodies[static_cast<std::size_t>(traction.body)];
    const BodySeeds all(scene, traction.body);
    const std::int64_t total = all.count(0, all.rows());
    LoadedPart part;
    std::vector<Seed> seeds;
    for (std::int64_t row = 0; row < all.rows(); ++row) {
        seeds.clear();
        all.fill(row, row + 1, total, seeds);
        for (const Seed& seed : seeds) {
            const double place = load_place(scene, traction, traction.body, seed.x);
            if (!(place > 0)) continue;
            const double area = seed.volume * line_share(traction.depth, traction.spacing, place).q;
            Triple below = seed.x;
            for (std::size_t a = 0; a < 3; ++a) below[a] -= traction.normal[a] * (place - 0.51 * traction.spacing);
            part.area += area;
            if (place > 0.51 * traction.spacing && !is_inside(body, scene.dimensions, below)) part.through += area;
        }
    }
    return part;
}

}  // namespace moraine
