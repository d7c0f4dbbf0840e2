#include "predict/scene_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/material/laws.hpp"
#include "core/method.hpp"
#include "predict/prediction.hpp"
#include "seeding/seed_region.hpp"

namespace moraine {
namespace {

constexpr double fewest_cells = 4, stiffest_poisson = 0.495, most_mach = 0.3;

/// P-wave modulus over shear modulus.
double wave_over_shear(double poisson) {
    return (2 - 2 * poisson) / (1 - 2 * poisson);
}

/// Axes along which a body fills the domain have no cells to count: a strip in 3-D may be as narrow as one.
void warn_of_cells(const Scene& scene, const BodySpec& body, std::vector<std::string>& all) {
    const Extent e = extent_of(body, scene.dimensions);
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
        square += 2 * std::abs(scene.gravity[a]) * (e.upper[a] - e.lower[a]);
    const double speed = std::sqrt(square), wave = wave_speed(scene, body);
    if (speed <= most_mach * wave) return;
    const std::string& material = scene.materials[static_cast<std::size_t>(body.material)].name;
    all.push_back(
        fmt::format("body.{} may flow at Mach {:.2g} ({:.3g} m/s by its height and start, waves {:.3g} m/s: above 0.3 "
                    "it is squeezed by its own speed). An elasticity of material.{} {:.2g} times as large?",
                    body.name, speed / wave, speed, wave, material, std::pow(speed / wave / most_mach, 2)));
}

/// As its motion says; of a free one at the start.
double fastest(const MotionSpec& motion) {
    double factor = 1;
    if (motion.kind == StructureMotion::sinusoid) return 2 * std::numbers::pi * norm(motion.amplitude) / motion.period;
    if (motion.kind == StructureMotion::table) {
        factor = 0;
        for (const double f : motion.factors) factor = std::max(factor, std::abs(f));
    }
    return motion.kind == StructureMotion::fixed ? 0 : factor * norm(motion.velocity);
}

/// Steps are as long as waves need: what is as fast as they crosses a cell in a step, and thin soil unseen.
void warn_of_fast_structures(const Scene& scene, std::vector<std::string>& all) {
    double wave = std::numeric_limits<double>::infinity();
    for (const BodySpec& body : scene.bodies) wave = std::min(wave, wave_speed(scene, body));
    for (const StructureSpec& s : scene.structures) {
        const double speed = fastest(s.motion);
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
        // `check` counts the cells of layers and inflows.
        if (body.shape == BodyShape::table || body.shape == BodyShape::layer || body.shape == BodyShape::inflow)
            continue;
        warn_of_cells(scene, body, all);
        warn_of_mach(scene, body, all);
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
