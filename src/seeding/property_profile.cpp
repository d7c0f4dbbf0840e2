#include "seeding/property_profile.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/data/time_table.hpp"
#include "core/material/laws.hpp"
#include "core/structures/ground.hpp"
#include "core/structures/structure.hpp"
#include "seeding/seed.hpp"
#include "seeding/seed_layer.hpp"
#include "seeding/seed_state.hpp"

namespace moraine {
namespace {

/// Up, and the axis that is nearest to it.
struct Upward {
    Triple direction{};  ///< of length 1
    std::size_t axis;
};

/// Against gravity; without it along the last axis.
Upward upward(const Scene& scene) {
    const Triple& g = scene.gravity;
    const double size = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    if (size > 0) return {{-g[0] / size, -g[1] / size, -g[2] / size}, static_cast<std::size_t>(up_axis(scene))};
    Upward up{{}, static_cast<std::size_t>(scene.dimensions - 1)};
    up.direction[up.axis] = 1;
    return up;
}

/// Way along `up` from x to the last edge of the polygon that it crosses; up has a part in the polygon's plane.
double way_out_of_polygon(const BodySpec& body, const Triple& up, const Triple& x) {
    const double square = up[0] * up[0] + up[1] * up[1];
    double way = 0;
    const std::size_t n = body.points.size();
    for (std::size_t i = 0, j = n - 1; i < n; j = i++) {
        const double ax = body.points[j][0] - x[0], ay = body.points[j][1] - x[1];
        const double bx = body.points[i][0] - x[0], by = body.points[i][1] - x[1];
        const double a = up[0] * ay - up[1] * ax, b = up[0] * by - up[1] * bx;  // to the left of the line
        if ((a > 0) == (b > 0)) continue;
        const double t = a / (a - b);
        way = std::max(way, ((ax + t * (bx - ax)) * up[0] + (ay + t * (by - ay)) * up[1]) / square);
    }
    return way;
}

double way_out_of_sphere(const BodySpec& body, int dimensions, const Triple& up, const Triple& x) {
    double along = 0, square = 0;
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimensions); ++a) {
        const double d = body.center[a] - x[a];
        along += d * up[a], square += d * d;
    }
    return along + std::sqrt(std::max(0.0, along * along + body.radius * body.radius - square));
}

double way_out_of_layer(const BodySpec& body, const Triple& up, const Triple& x) {
    const GroundPoint<3> b = ground_at<3>(body.ground->table.data(), {{x[0], x[1], x[2]}});
    const double rise = (up[2] - b.slope[0] * up[0] - b.slope[1] * up[1]) / secant_of(b);
    return (layer_thickness(body, x[0], x[1]) - height_in_layer(body, x)) / rise;
}

/// A profile as a function of depth alone, at one place in plan.
class DepthCurve {
  public:
    DepthCurve(const ProfileSpec& profile, const Triple& x) : profile_(profile) {
        surface_ = profile.raster ? raster_value(*profile.raster, x[0], x[1]) : profile.surface;
    }

    double at(double depth) const {
        if (!profile_.depth.empty()) return value_between(profile_.depth, profile_.value, depth);
        return surface_ + profile_.gradient * depth;
    }

    /// From no depth to this one.
    double integral(double depth) const {
        if (!(depth > 0)) return 0;
        if (!profile_.depth.empty()) return TimeTable{profile_.depth, profile_.value}.mean(0, depth) * depth;
        return (surface_ + 0.5 * profile_.gradient * depth) * depth;
    }

  private:
    const ProfileSpec& profile_;
    double surface_;
};

const MaterialSpec& material_of(const Scene& scene, const BodySpec& body) {
    return scene.materials[static_cast<std::size_t>(body.material)];
}

/// No particle of the body is deeper below where a profile counts from [m].
double greatest_depth(const Scene& scene, const BodySpec& body, const ProfileSpec& profile) {
    const auto [up, axis] = upward(scene);
    Triple low = scene.min, high = scene.max;
    if (has_surface(body)) {
        const Extent extent = extent_of(body, scene.dimensions);
        low = extent.lower, high = extent.upper;
    }
    const double bottom = up[axis] > 0 ? low[axis] : high[axis], top = up[axis] > 0 ? high[axis] : low[axis];
    return std::max(0.0, (profile.from.value_or(top) - bottom) / up[axis]);
}

}  // namespace

void choose_law_over_depth(MaterialSpec& material) {
    const LawInfo* uniform = find_law(material.law);
    if (uniform->uniform) uniform = find_law(uniform->uniform);
    OwnScalars own{.properties = {}, .strength = material.keeps_strength};
    for (const ProfileSpec& p : material.profiles) own.properties.push_back(p.property);
    const bool varies = own.strength || !own.properties.empty();
    const LawInfo* law = varies ? find_law_over_depth(*uniform, own) : uniform;
    if (!law) throw std::logic_error("no law keeps this property per particle");
    material.law = law->name;
    for (ProfileSpec& p : material.profiles)
        p.scalar = scalar_named(*law, property_name(*law, static_cast<std::size_t>(p.property)));
}

void set_profile(MaterialSpec& material, std::size_t property, ProfileSpec profile) {
    profile.property = static_cast<int>(property);
    std::erase_if(material.profiles, [&](const ProfileSpec& p) { return p.property == profile.property; });
    material.profiles.push_back(std::move(profile));
    choose_law_over_depth(material);
}

bool has_surface(const BodySpec& body) {
    return body.shape != BodyShape::table && body.shape != BodyShape::inflow;
}

double depth_at(const Scene& scene, const BodySpec& body, const ProfileSpec& profile, const Triple& x) {
    const auto [up, axis] = upward(scene);
    const auto below = [&, up = up, axis = axis](double height) {
        return std::max(0.0, (height - x[axis]) / up[axis]);
    };
    if (profile.from) return below(*profile.from);
    switch (body.shape) {
        case BodyShape::sphere:
            return way_out_of_sphere(body, scene.dimensions, up, x);
        case BodyShape::layer:
            return std::max(0.0, way_out_of_layer(body, up, x));
        case BodyShape::polygon:
            if (axis < 2) return way_out_of_polygon(body, up, x);
            break;
        default:
            break;
    }
    return below(up[axis] > 0 ? body.max[axis] : body.min[axis]);
}

double profile_at(const Scene& scene, const BodySpec& body, const ProfileSpec& profile, const Triple& x) {
    return DepthCurve(profile, x).at(profile.counts_depth() ? depth_at(scene, body, profile, x) : 0);
}

double density_at(const Scene& scene, const BodySpec& body, const Triple& x) {
    const MaterialSpec& m = material_of(scene, body);
    const ProfileSpec* profile = m.density_profile();
    return profile ? profile_at(scene, body, *profile, x) : m.density;
}

double mass_above(const Scene& scene, const BodySpec& body, const Triple& x, double height) {
    const MaterialSpec& m = material_of(scene, body);
    const ProfileSpec* profile = m.density_profile();
    if (!profile) return m.density * height;
    const auto [up, axis] = upward(scene);
    const double rise = std::fabs(up[axis]);  // of a height on the way along gravity
    const double depth = profile->counts_depth() ? depth_at(scene, body, *profile, x) : 0;
    const double within = std::min(height, depth * rise);
    const DepthCurve curve(*profile, x);
    return rise * (curve.integral(depth) - curve.integral(depth - within / rise)) + curve.at(0) * (height - within);
}

ProfileRange profile_range(const Scene& scene, int body, const ProfileSpec& profile) {
    const BodySeeds all(scene, body);
    ProfileRange range{HUGE_VAL, -HUGE_VAL};
    std::vector<Seed> seeds;
    for (std::int64_t row = 0; row < all.rows(); ++row) {
        seeds.clear();
        all.fill(row, row + 1, 1, seeds);
        for (const Seed& seed : seeds) {
            const double s = profile_at(scene, scene.bodies[static_cast<std::size_t>(body)], profile, seed.x);
            if (std::isnan(s)) return {s, s, seed.x};
            if (s < range.least) range.least = s, range.where = seed.x;
            range.most = std::max(range.most, s);
        }
    }
    return range;
}

ProfileRange profile_bounds(const Scene& scene, int material, const ProfileSpec& profile) {
    ProfileRange range{HUGE_VAL, -HUGE_VAL};
    const auto take = [&](double value) {
        range.least = std::min(range.least, value), range.most = std::max(range.most, value);
    };
    for (const double value : profile.value) take(value);
    if (!profile.value.empty()) return range;
    if (profile.raster)
        for (const double value : profile.raster->height) std::isnan(value) ? void() : take(value);
    else
        take(profile.surface);
    double depth = 0;
    for (const BodySpec& body : scene.bodies)
        if (body.material == material) depth = std::max(depth, greatest_depth(scene, body, profile));
    take((profile.gradient > 0 ? range.most : range.least) + profile.gradient * depth);
    return range;
}

}  // namespace moraine
