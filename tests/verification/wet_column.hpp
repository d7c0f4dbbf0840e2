#pragma once
// A column of saturated elastic soil, 1 m high, on a closed base: what the tests of water in the ground begin with.

#include <algorithm>

#include "seeding/traction_place.hpp"
#include "verification/run.hpp"

namespace moraine::verification::wet {

inline constexpr double height = 1, young = 1e7, poisson = 0.3, porosity = 0.4, density = 1990, water_bulk = 2.2e8;
inline constexpr double M = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson)), Q = water_bulk / porosity;

/// As a strip.
inline Scene column(int cells, double conductivity) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = height / cells;
    scene.max = {4 * scene.cell, height + 2 * scene.cell, 0};
    scene.cfl = 0.6;
    choose(scene, quadratic_apic_usl);
    make_periodic(scene, 0);
    scene.walls[1][0].kind = WallKind::free_slip;
    scene.water.on = true;
    scene.water.bulk = water_bulk;
    MaterialSpec soil = material("linear-elastic", density, {{"young", young}, {"poisson", poisson}});
    soil.porosity = porosity, soil.conductivity = conductivity;
    soil.volumetric = Volumetric::grid;
    scene.materials.push_back(soil);
    BodySpec body;
    body.max = {scene.max[0], height, 0};
    body.particles_per_cell = {2, 2, 1};  // one across would lie on faces of the cells around nodes
    scene.bodies.push_back(body);
    return scene;
}

/// Mean over the particles.
template <class Real, class F>
double mean(Run<Real>& run, const F& f) {
    return run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto& x) { return f(p, s, X, x); }) /
           static_cast<double>(run.particles());
}

template <class Real>
double settlement(Run<Real>& run) {
    return height * mean(run, [](const auto& p, std::uint32_t s, const auto&, const auto&) {
               return -std::expm1(double(p.ln_J[s]));
           });
}

/// Terzaghi: a series over odd multiples of pi / 2.
template <class F>
double series(double T, const F& term) {
    double sum = 0;
    for (int k = 0; k < 200; ++k) {
        const double a = (2 * k + 1) * pi / 2;
        sum += term(a) * std::exp(-a * a * T);
    }
    return sum;
}

/// A plate on the column, whose pressure [Pa] grows for some time [s].
inline void press(Scene& scene, double pressure, double ramp) {
    TractionSpec plate;
    plate.normal = {0, 1, 0}, plate.pressure = pressure;
    plate.depth = 3 * scene.cell, plate.spacing = line_spacing(scene, plate);
    plate.factor = {{0, ramp}, {0, 1}};
    scene.course.tractions.push_back(plate);
}

/// Water that seeps along a slope through ground as high as the column, and bears its share.
template <class View>
void seep(double slope, double k, const View& p, std::uint32_t s, const std::array<double, 2>& X) {
    const double depth = height - X[1], across = 9.81 * std::cos(slope) * depth;
    p.pore_pressure[s] = 1000 * across;
    for (int a = 0; a < 3; ++a) p.stress[s][a] = -(density - 1000) * across;
    p.stress[s][Sym<double, 2>::index(0, 1)] = density * 9.81 * std::sin(slope) * depth;
    p.darcy_velocity[s][0] = k * std::sin(slope);
}

}  // namespace moraine::verification::wet
