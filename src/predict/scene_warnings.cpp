#include "predict/scene_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/courant.hpp"
#include "core/gravity.hpp"
#include "core/material/laws.hpp"
#include "core/structures/rigid_body.hpp"
#include "core/transfer/method.hpp"
#include "predict/prediction.hpp"
#include "seeding/inflow.hpp"
#include "seeding/seed_region.hpp"

namespace moraine {
namespace {

constexpr double fewest_cells = 4, stiffest_poisson = 0.495, most_mach = 0.3;
/// Of the material's viscosity. From half of it on films are up to half as fast as they should be, at a twentieth some
/// percents slower (docs/verification/flows.md#films-of-low-viscosity).
constexpr double most_share = 0.5, good_share = 0.05;

/// P-wave modulus over shear modulus.
double wave_over_shear(double poisson) {
    return (2 - 2 * poisson) / (1 - 2 * poisson);
}

/// Whether two boxes lie on each other: alike along all axes but one, and along that with one face in common.
bool touch(const Extent& one, const Extent& other, int dimensions, double near) {
    int apart = 0;
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimensions); ++a) {
        const double low = std::abs(one.lower[a] - other.lower[a]), high = std::abs(one.upper[a] - other.upper[a]);
        if (low <= near && high <= near) continue;
        if (std::min(std::abs(one.upper[a] - other.lower[a]), std::abs(other.upper[a] - one.lower[a])) > near)
            return false;
        ++apart;
    }
    return apart == 1;
}

/// Of the boxes that lie on a box and on each other, as layers do: they flow as one.
Extent joined_extent(const Scene& scene, const BodySpec& body) {
    Extent all = extent_of(body, scene.dimensions);
    if (body.shape != BodyShape::box) return all;
    for (bool grows = true; grows;) {
        grows = false;
        for (const BodySpec& other : scene.bodies) {
            if (other.shape != BodyShape::box) continue;
            const Extent e = extent_of(other, scene.dimensions);
            if (!touch(all, e, scene.dimensions, 1e-9 * scene.cell)) continue;
            for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
                all.lower[a] = std::min(all.lower[a], e.lower[a]);
                all.upper[a] = std::max(all.upper[a], e.upper[a]);
            }
            grows = true;
        }
    }
    return all;
}

/// Releases and inflows, by their thickness over the ground.
void warn_of_thickness(const Scene& scene, const BodySpec& body, std::vector<std::string>& all) {
    const double thickness = body.hydrograph ? peak_depth(body) : body.thickness, cells = thickness / scene.cell;
    if (cells >= fewest_cells * (1 - 1e-9)) return;
    all.push_back(fmt::format(
        "{}.{} is {:.3g} cells thick (fewer than 4 do not resolve a flow: it is too fast). A domain.cell of {:.3g} m?",
        body.shape == BodyShape::inflow ? "inflow" : "release", body.name, cells, thickness / fewest_cells));
}

/// Axes along which a body fills the domain have no cells to count: a strip in 3-D may be as narrow as one.
void warn_of_cells(const Scene& scene, const BodySpec& body, std::vector<std::string>& all) {
    const Extent e = joined_extent(scene, body);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        const double side = e.upper[a] - e.lower[a];
        if (side < (scene.max[a] - scene.min[a]) * (1 - 1e-9)) least = std::min(least, side / scene.cell);
    }
    if (least >= fewest_cells * (1 - 1e-9)) return;
    all.push_back(fmt::format(
        "body.{} is {:.3g} cells over its least side (fewer than 4 do not resolve a flow). A domain.cell of {:.3g} m?",
        body.name, least, scene.cell * least / fewest_cells));
}

/// The speed of a fall from the body's top to its bottom beside that of the start.
void warn_of_mach(const Scene& scene, const BodySpec& body, std::vector<std::string>& all) {
    const Extent e = extent_of(body, scene.dimensions);
    double square = norm(body.velocity) * norm(body.velocity);
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        square += 2 * largest_gravity(scene) * std::abs(scene.gravity[a]) * (e.upper[a] - e.lower[a]);
    const double speed = std::sqrt(square), wave = wave_speed(scene, body);
    if (speed <= most_mach * wave) return;
    const std::string& material = scene.materials[static_cast<std::size_t>(body.material)].name;
    all.push_back(
        fmt::format("body.{} may flow at Mach {:.2g} ({:.3g} m/s by its height and start, waves {:.3g} m/s: above 0.3 "
                    "it is squeezed by its own speed). An elasticity of material.{} {:.2g} times as large?",
                    body.name, speed / wave, speed, wave, material, std::pow(speed / wave / most_mach, 2)));
}

/// Of the amplitude of a shear wave, over (k h)^4, in a step: tests/verification/test_shear_wave.cpp.
double loss_of_transfer(const Scene& scene) {
    if (scene.shape == Shape::cubic) return scene.transfer == Transfer::apic ? 0.046 : 0;
    if (scene.shape != Shape::quadratic) return 0;
    switch (scene.transfer) {
        case Transfer::apic:
            return 0.024;
        case Transfer::tpic:
            return 0.032;
        case Transfer::aflip:
            return 0.024 * (1 - scene.flip);
        default:
            return 0;
    }
}

/// Something of another law than smooth, or a wall below that holds.
bool has_rough_bed(const Scene& scene, std::size_t up) {
    const WallKind below = scene.walls[up][scene.gravity[up] < 0 ? 0 : 1].kind;
    return below == WallKind::no_slip || below == WallKind::friction ||
           std::any_of(scene.structures.begin(), scene.structures.end(),
                       [](const StructureSpec& s) { return s.law != InterfaceLaw::smooth; });
}

/// A layer of depth D that shears over its bed is a quarter of a wave, k = pi / 2D, so a loss c (k h)^4 a step is a
/// kinematic viscosity c k^2 h^4 / dt [m2/s], at the longest step.
void warn_of_transfer(const Scene& scene, const BodySpec& body, std::vector<std::string>& all) {
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(body.material)];
    const std::span<const Parameter> keys = find_law(m.law)->parameters;
    const auto key =
        std::find_if(keys.begin(), keys.end(), [](const Parameter& p) { return p.key == std::string("viscosity"); });
    if (key == keys.end() || scene.dt > 0) return;
    const double viscosity = m.parameters[static_cast<std::size_t>(key - keys.begin())] / m.density;
    const auto up =
        static_cast<std::size_t>(std::max_element(scene.gravity.begin(), scene.gravity.end(),
                                                  [](double a, double b) { return std::abs(a) < std::abs(b); }) -
                                 scene.gravity.begin());
    if (scene.gravity[up] == 0 || viscosity == 0 || !has_rough_bed(scene, up)) return;
    const Extent e = extent_of(body, scene.dimensions);
    const double depth = e.upper[up] - e.lower[up], k = 0.5 * std::numbers::pi / depth;
    const double shear = 1 / std::sqrt(wave_over_shear(poisson_ratio(m)));
    const double dt = choose_step(scene, wave_speed(scene, body), 0, shear).dt;
    const double share = loss_of_transfer(scene) * k * k * std::pow(scene.cell, 4) / dt / viscosity;
    if (share <= most_share) return;
    all.push_back(
        fmt::format("body.{} is {:.3g} cells deep, and there the transfer itself is as viscous as {:.2g} of "
                    "material.{} (over a bed that holds it, it flows too slowly). numerics.transfer = \"flip\", or a "
                    "domain.cell of {:.2g} m?",
                    body.name, depth / scene.cell, share, m.name, scene.cell * std::cbrt(good_share / share)));
}

/// From the centre to the furthest point of a structure that turns [m].
double reach_of(const StructureSpec& s) {
    const auto half = [](const Triple& a, const Triple& b) {
        return 0.5 * norm({b[0] - a[0], b[1] - a[1], b[2] - a[2]});
    };
    if (s.shape != StructureShape::polygon) return s.radius + std::max(half(s.min, s.max), half(s.from, s.to));
    const Vec<double, 2> centre = centre_of_mass<2>(s);
    double flat = 0;
    for (const auto& p : s.points) flat = std::max(flat, std::hypot(p[0] - centre[0], p[1] - centre[1]));
    return std::hypot(flat, half(s.min, s.max));
}

/// As its motion says; of a free one at the start.
double fastest(const StructureSpec& s) {
    const MotionSpec& motion = s.motion;
    if (motion.kind == StructureMotion::sinusoid) return 2 * std::numbers::pi * norm(motion.amplitude) / motion.period;
    const double factor = motion.kind == StructureMotion::table ? motion.factor.largest() : 1;
    double turns = 0;
    for (const double w : motion.angular_velocity) turns = std::hypot(turns, w);
    return motion.kind == StructureMotion::fixed ? 0 : factor * (norm(motion.velocity) + turns * reach_of(s));
}

/// Steps are as long as waves need: what is as fast as they crosses a cell in a step, and thin soil unseen.
void warn_of_fast_structures(const Scene& scene, std::vector<std::string>& all) {
    double wave = std::numeric_limits<double>::infinity();
    for (const BodySpec& body : scene.bodies) wave = std::min(wave, wave_speed(scene, body));
    for (const StructureSpec& s : scene.structures) {
        const double speed = fastest(s);
        if (speed <= most_mach * wave) continue;
        all.push_back(
            fmt::format("structure.{} moves at Mach {:.2g} ({:.3g} m/s, waves {:.3g} m/s: above 0.3 it squeezes soil, "
                        "and above 1 it can pass through it between two steps). Is its speed in m/s?",
                        s.name, speed / wave, speed, wave));
    }
}

bool along_the_grid(const StructureSpec& plane) {
    return std::count_if(plane.normal.begin(), plane.normal.end(), [](double n) { return n != 0; }) == 1;
}

/// Cells that a bed cuts at an angle have no exact integrals (docs/adr/0009).
void warn_of_smooth_beds(const Scene& scene, std::vector<std::string>& all) {
    for (const MaterialSpec& m : scene.materials) {
        if (m.volumetric != Volumetric::grid) continue;
        for (const StructureSpec& s : scene.structures) {
            const bool bed =
                s.shape == StructureShape::ground || (s.shape == StructureShape::plane && !along_the_grid(s));
            if (s.law != InterfaceLaw::smooth || !bed) continue;
            all.push_back(
                fmt::format("material.{} sinks into {}, by up to a cell in 10 s (pressures on cells, and a bed without "
                            "friction that is not along the grid). A law with friction, or "
                            "material.{}.volumetric = \"particle\"?",
                            m.name, s.name, m.name));
        }
    }
}

}  // namespace

std::vector<std::string> scene_warnings(const Scene& scene) {
    std::vector<std::string> all;
    for (const BodySpec& body : scene.bodies) {
        if (body.shape == BodyShape::table) continue;
        if (body.shape == BodyShape::layer || body.shape == BodyShape::inflow) {
            warn_of_thickness(scene, body, all);
            continue;
        }
        warn_of_cells(scene, body, all);
        warn_of_mach(scene, body, all);
        warn_of_transfer(scene, body, all);
    }
    for (const MaterialSpec& m : scene.materials) {
        const double poisson = poisson_ratio(m);
        if (poisson <= stiffest_poisson || poisson >= 0.5) continue;
        all.push_back(fmt::format(
            "material.{}.poisson = {:.6g} makes steps {:.2g} times as short as 0.495 does (which is incompressible "
            "enough for a flow). Use 0.495?",
            m.name, poisson, std::sqrt(wave_over_shear(poisson) / wave_over_shear(stiffest_poisson))));
    }
    warn_of_fast_structures(scene, all);
    warn_of_smooth_beds(scene, all);
    return all;
}

}  // namespace moraine
