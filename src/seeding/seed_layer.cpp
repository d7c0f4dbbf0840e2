#include "seeding/seed_layer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/structures/ground.hpp"
#include "seeding/seed_region.hpp"

namespace moraine {
namespace {

using Ring = std::vector<std::array<double, 2>>;

/// The part of a polygon on one side of a line across an axis (Sutherland and Hodgman 1974): sign 1: above it. Where a
/// polygon falls into parts these are joined by edges that enclose nothing.
Ring cut(const Ring& ring, std::size_t axis, double at, double sign) {
    Ring part;
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
        const double here = sign * (ring[i][axis] - at), before = sign * (ring[j][axis] - at);
        if ((here < 0) != (before < 0)) {
            const double t = before / (before - here);
            std::array<double, 2> p;
            p[1 - axis] = ring[j][1 - axis] + t * (ring[i][1 - axis] - ring[j][1 - axis]);
            p[axis] = at;
            part.push_back(p);
        }
        if (here >= 0) part.push_back(ring[i]);
    }
    return part;
}

Ring between(const Ring& ring, std::size_t axis, double low, double high) {
    return ring.empty() ? ring : cut(cut(ring, axis, low, 1), axis, high, -1);
}

/// Signed area and its first moments about the first corner.
std::array<double, 3> moments_of(const Ring& ring) {
    std::array<double, 3> m{};
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
        const double ax = ring[i][0] - ring[0][0], ay = ring[i][1] - ring[0][1];
        const double bx = ring[i + 1][0] - ring[0][0], by = ring[i + 1][1] - ring[0][1];
        const double area = 0.5 * (ax * by - ay * bx);
        m[0] += area, m[1] += area * (ax + bx) / 3, m[2] += area * (ay + by) / 3;
    }
    return m;
}

GroundPoint<3> point_at(const BodySpec& body, double x, double y) {
    return ground_at<3>(body.ground->table.data(), {{x, y, 0}});
}

}  // namespace

double secant_of(const GroundPoint<3>& point) {
    return std::sqrt(1 + point.slope[0] * point.slope[0] + point.slope[1] * point.slope[1]);
}

double layer_volume(const BodySpec& body) {
    const double side = 0.5 * body.ground->spacing;
    const Extent e = extent_of(body, 3);
    double sum = 0;
    for (double y = e.lower[1]; y < e.upper[1]; y += side) {
        const Ring strip = between(body.points, 1, y, y + side);
        if (strip.size() < 3) continue;
        for (double x = e.lower[0]; x < e.upper[0]; x += side) {
            const Ring cell = between(strip, 0, x, x + side);
            if (cell.size() < 3) continue;
            const auto [area, mx, my] = moments_of(cell);
            if (area == 0) continue;
            const double px = cell[0][0] + mx / area, py = cell[0][1] + my / area;
            const double part = body.thickness_raster.values ? layer_thickness(body, px, py) / body.thickness : 1.0;
            sum += area * secant_of(point_at(body, px, py)) * part;
        }
    }
    return body.thickness * std::fabs(sum);
}

double height_in_layer(const BodySpec& body, const Triple& x) {
    const GroundPoint<3> ground = point_at(body, x[0], x[1]);
    return (x[2] - ground.height) / secant_of(ground);
}

double layer_thickness(const BodySpec& body, double x, double y) {
    if (!body.thickness_raster.values) return body.thickness;
    const double t = raster_value(*body.thickness_raster.values, x, y);
    return std::isnan(t) ? 0.0 : std::min(t, body.thickness);
}

double layer_top(const BodySpec& body) {
    const auto [left, right] = std::minmax_element(body.points.begin(), body.points.end());
    const auto [low, high] = std::minmax_element(body.points.begin(), body.points.end(),
                                                 [](const auto& p, const auto& q) { return p[1] < q[1]; });
    double top = -std::numeric_limits<double>::infinity();
    for (double y = (*low)[1]; y < (*high)[1] + body.ground->spacing; y += body.ground->spacing)
        for (double x = (*left)[0]; x < (*right)[0] + body.ground->spacing; x += body.ground->spacing) {
            const GroundPoint<3> b = point_at(body, std::min(x, (*right)[0]), std::min(y, (*high)[1]));
            top = std::max(top, b.height + body.thickness * secant_of(b));
        }
    return top;
}

Layer::Layer(const Scene& scene, const BodySpec& body) : body_(body) {
    const Extent e = extent_of(body, 3);
    for (std::size_t a = 0; a < 2; ++a) {
        spacing_[a] = scene.cell / body.particles_per_cell[a];
        const double first = std::floor((e.lower[a] - scene.min[a]) / spacing_[a]);
        first_[a] = scene.min[a] + (first + 0.5) * spacing_[a];
        count_[a] = std::llround(std::ceil((e.upper[a] - scene.min[a]) / spacing_[a]) - first);
    }
    spacing_along_normal_ = scene.cell / body.particles_per_cell[2];
    layers_ = std::max<std::int64_t>(1, std::llround(body.thickness * body.particles_per_cell[2] / scene.cell));
    double sum = 0;
    particles_.push_back(0);
    for (std::int64_t j = 0; j < count_[1]; ++j) {
        std::int64_t particles = 0;
        for (std::int64_t i = 0; i < count_[0]; ++i) {
            const Column c = column(i, j);
            sum += c.particles > 0 ? c.weight : 0;
            particles += c.particles;
        }
        particles_.push_back(particles_.back() + particles);
    }
    if (sum > 0) share_ = layer_volume(body) / (sum * static_cast<double>(layers_));
}

std::int64_t Layer::count(std::int64_t first, std::int64_t last) const {
    return particles_[static_cast<std::size_t>(last)] - particles_[static_cast<std::size_t>(first)];
}

Layer::Column Layer::column(std::int64_t i, std::int64_t j) const {
    const double x = first_[0] + static_cast<double>(i) * spacing_[0];
    const double y = first_[1] + static_cast<double>(j) * spacing_[1];
    Column c;
    if (!is_in_polygon(body_, x, y)) return c;
    const GroundPoint<3> ground = point_at(body_, x, y);
    c.foot = {x, y, ground.height};
    c.weight = secant_of(ground);
    c.height = c.weight * body_.thickness;
    c.particles = layers_;
    if (body_.thickness_raster.values) {
        const double thickness = layer_thickness(body_, x, y);
        c.height = c.weight * thickness;
        c.weight *= thickness / body_.thickness;
        c.particles = std::llround(thickness / spacing_along_normal_);
    }
    return c;
}

}  // namespace moraine
