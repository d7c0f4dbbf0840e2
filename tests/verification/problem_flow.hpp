#pragma once
// SEED-1, R8 and R4 as runs: a slurry behind a gate (inputs/slurry_runout.toml), a column of sand of aspect ratio 2
// (inputs/granular_column.toml), a viscous current (inputs/viscous_current.toml) and a dam break (that of
// benchmarks/stability/dam_breaks), each `cells` cells over the height of the fluid, or the half width of the sand; and
// where their fronts are.

#include <algorithm>

#include "core/courant.hpp"
#include "verification/run.hpp"

namespace moraine::verification {

inline constexpr double gate = 10, reservoir_height = 5;                ///< SEED-1 [m]
inline constexpr double column_width = 0.1, column_end = 0.86;          ///< R8 [m, s]
inline constexpr double block_side = 0.1, current_end = 30;             ///< R4 [m, s]
inline constexpr double dam_gate = 9, dam_depth = 1;                    ///< dam break [m]
inline const double dam_break_end = 7.5 / std::sqrt(9.81 / dam_depth);  ///< [s]

/// A box in the corner of a plane of symmetry and a bed, in balance with its weight, and the step of the method.
inline Scene flow_scene(const Choice& choice, double cell, const Triple& domain, const Triple& box, double k0) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = cell;
    scene.max = domain;
    scene.gravity = {0, -9.81, 0};
    choose(scene, choice);
    scene.cfl = standard_courant(scene);
    scene.walls[0][0].kind = WallKind::free_slip;
    scene.walls[0][1].kind = WallKind::open;
    scene.walls[1][0].kind = WallKind::no_slip;
    BodySpec body;
    body.max = box;
    body.geostatic = true;
    body.geostatic_surface = box[1];
    body.geostatic_k0 = k0;
    scene.bodies.push_back(body);
    return scene;
}

inline Scene slurry_scene(const Choice& choice, int cells) {
    Scene scene = flow_scene(choice, reservoir_height / cells, {100, 8, 0}, {gate, reservoir_height, 0}, 1);
    scene.end = 20;
    scene.materials.push_back(
        material("bingham", 1500, {{"young", 2.5e5}, {"poisson", 0.495}, {"viscosity", 50}, {"yield_stress", 500}}));
    return scene;
}

inline Scene sand_scene(const Choice& choice, int cells, WallKind bed) {
    Scene scene = flow_scene(choice, column_width / cells, {2, 1.2, 0}, {column_width, 2 * column_width, 0}, 0.6);
    scene.end = column_end;
    scene.walls[1][0].kind = bed;
    scene.walls[1][0].friction = 0.6;
    scene.materials.push_back(material("mu-i", 1600,
                                       {{"young", 2e6},
                                        {"poisson", 0.24},
                                        {"static_friction", 0.6},
                                        {"limit_friction", 0.86},
                                        {"inertial_number", 0.279},
                                        {"grain_diameter", 1e-3},
                                        {"grain_density", 2650}}));
    return scene;
}

inline Scene current_scene(const Choice& choice, int cells) {
    Scene scene = flow_scene(choice, block_side / cells, {0.8, 0.12, 0}, {block_side, block_side, 0}, 1);
    scene.end = current_end;
    scene.materials.push_back(material("newtonian", 1000, {{"young", 3e3}, {"poisson", 0.495}, {"viscosity", 5}}));
    return scene;
}

/// Without viscosity, on a smooth bed; waves at 40 m/s.
inline Scene dam_break_scene(const Choice& choice, int cells) {
    Scene scene = flow_scene(choice, dam_depth / cells, {40, 4, 0}, {dam_gate, dam_depth, 0}, 1);
    scene.end = dam_break_end;
    scene.walls[1][0].kind = WallKind::free_slip;
    scene.materials.push_back(material("newtonian", 1000, {{"young", 47366}, {"poisson", 0.495}, {"viscosity", 0}}));
    return scene;
}

/// Place with a share of the particles ahead [m]. Binned state; on one rank.
template <class Real>
double front(Simulation<Real, 2>& sim, double ahead = 0.005) {
    std::vector<double> x;
    each_particle(sim, [&](std::uint32_t, const std::array<double, 2>& at) { x.push_back(at[0]); });
    if (x.empty()) return NAN;
    const double place = (1 - ahead) * static_cast<double>(x.size() - 1);
    const auto below = x.begin() + static_cast<std::ptrdiff_t>(place);
    std::nth_element(x.begin(), below, x.end());
    const double low = *below, high = below + 1 == x.end() ? low : *std::min_element(below + 1, x.end());
    return low + (place - std::floor(place)) * (high - low);
}

/// R4: where Huppert's current (1982) of the area q = block_side^2 has the same share ahead, nu = 0.005 m2/s:
/// x_N = 1.41124 (g q^3 t / (3 nu))^(1/5), depth as (1 - (x / x_N)^2)^(1/3).
inline double huppert_front(double t, double ahead = 0.005) {
    const int n = 20000;
    double whole = 0, sum = 0, s = 1;
    const auto depth = [](double x) { return std::cbrt(1 - x * x); };
    for (int k = 0; k < n; ++k) whole += depth((k + 0.5) / n);
    for (int k = n - 1; k >= 0 && sum < ahead * whole; --k) sum += depth((k + 0.5) / n), s = double(k) / n;
    return s * 1.41124 * std::pow(9.81 * std::pow(block_side, 6) * t / 0.015, 0.2);
}

/// Depth against Ritter's (1892), h = (2 c0 - x / t)^2 / (9 g): mean of the difference over that of Ritter's, in
/// columns of a cell from -c0 t to c0 t of the gate. Binned state; on one rank.
template <class Real>
double ritter_error(Run<Real>& run) {
    const double cell = run.sim.scene().cell, c0 = std::sqrt(9.81 * dam_depth), reach = c0 * run.time();
    std::vector<double> depth(static_cast<std::size_t>(2 * reach / cell));
    const double share = dam_gate * dam_depth / static_cast<double>(run.particles()) / cell;
    each_particle(run.sim, [&](std::uint32_t, const std::array<double, 2>& at) {
        const double column = std::floor((at[0] - dam_gate + reach) / cell);
        if (column >= 0 && column < static_cast<double>(depth.size())) depth[static_cast<std::size_t>(column)] += share;
    });
    double off = 0, all = 0;
    for (std::size_t k = 0; k < depth.size(); ++k) {
        const double speed = ((static_cast<double>(k) + 0.5) * cell - reach) / run.time();
        const double exact = (2 * c0 - speed) * (2 * c0 - speed) / (9 * 9.81);
        off += std::fabs(depth[k] - exact), all += exact;
    }
    return off / all;
}

}  // namespace moraine::verification
