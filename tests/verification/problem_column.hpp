#pragma once
// E2 as a run: gravity is there at once, local damping brings the column to rest in some periods of its first mode, 4
// l0 / c; then its stress and places against the exact ones.

#include <algorithm>

#include "verification/exact_column.hpp"
#include "verification/run.hpp"

namespace moraine::verification {

struct Settled {
    double stress;      ///< sum V0 |sigma - exact| / (rho0 g l0 sum V0)
    double settlement;  ///< rms of the place's error over the settlement of the top
    double base;        ///< largest stress error in the lowest cell over the base pressure
    double speed;       ///< largest left, over the wave speed
};

inline Scene column_scene(const Column& column, int cells, const Choice& choice, const std::string& law, bool spline) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = column.height / cells;
    scene.max = {4 * scene.cell, column.height + 2 * scene.cell, 0};
    scene.boundary_spline = spline;
    scene.cfl = 0.4;
    scene.damping = 0.3;
    scene.gravity[1] = -column.gravity;
    choose(scene, choice);
    make_periodic(scene, 0);
    scene.walls[1][0].kind = WallKind::free_slip;
    scene.materials.push_back(material(law, column.density, {{"young", column.young}, {"poisson", 0}}));
    BodySpec body;
    body.max = {scene.max[0], column.height, 0};
    body.particles_per_cell = {1, 2, 1};
    scene.bodies.push_back(body);
    return scene;
}

template <class Real>
Settled settle(Run<Real>& run, const Column& column, double periods) {
    const Scene& scene = run.sim.scene();
    while (run.time() < periods * 4 * column.height / column.wave_speed()) run.steps(50);
    const double volume = scene.max[0] * column.height;
    const double particle = 0.5 * scene.cell * scene.cell;  // V0
    Settled settled;
    settled.stress = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
        return particle * std::fabs(p.stress[s](1, 1) - column.stress(X[1]));
    });
    settled.stress /= column.base_pressure() * volume;
    const bool elastic = scene.materials[0].law == "linear-elastic";
    const double top =
        column.height - (elastic ? column.place(column.height) : column.place_neo_hookean(column.height));
    settled.settlement = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
        const double error = x[1] - (elastic ? column.place(X[1]) : column.place_neo_hookean(X[1]));
        return particle * error * error;
    });
    settled.settlement = std::sqrt(settled.settlement / volume) / top;
    settled.base = run.largest([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
        return X[1] > scene.cell ? 0 : std::fabs(p.stress[s](1, 1) - column.stress(X[1])) / column.base_pressure();
    });
    settled.speed = totals_of(run.sim).speed.value / column.wave_speed();
    return settled;
}

}  // namespace moraine::verification
