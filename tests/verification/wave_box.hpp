#pragma once
// A packet of plane waves in a strip between two absorbing ends, periodic across, and what of its energy comes back.
#include "verification/run.hpp"

namespace moraine::verification {

/// Of P or S waves whose lines are `across` cells a wave along x (0: straight on the ends) and `cells` along y.
struct Packet {
    int cells = 10, across = 0;
    bool shear = false;
    double poisson = 0.25;
};

constexpr double soil_density = 1600, soil_young = 4e7;

inline Scene wave_box(const Packet& packet, const Choice& choice, int height) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 0.5;
    const int width = packet.across > 0 ? packet.across : 4;
    scene.max = {width * scene.cell, height * scene.cell, 0};
    scene.cfl = 0.5;
    scene.end = 1e3;
    choose(scene, choice);
    make_periodic(scene, 0);
    for (WallSpec& wall : scene.walls[1]) wall.kind = WallKind::law, wall.absorbs = true;
    scene.materials = {material("linear-elastic", soil_density, {{"young", soil_young}, {"poisson", packet.poisson}})};
    BodySpec body;
    body.max = scene.max;
    body.particles_per_cell = {2, 2, 1};
    scene.bodies = {body};
    return scene;
}

/// Wave speed [m/s].
inline double speed_of(const Packet& packet) {
    const double nu = packet.poisson, shear = soil_young / (2 * (1 + nu));
    return std::sqrt((packet.shear ? shear : shear * (2 - 2 * nu) / (1 - 2 * nu)) / soil_density);
}

/// A packet of some waves in the middle, of velocities alone, goes to both ends. Energy that has come back once it
/// should be gone, over that at its start: twice what is stored, because waves that travel hold half of theirs in
/// motion, and FLIP keeps velocities that no node sees.
template <class Real>
double energy_left(const Packet& packet, const Choice& choice, int height = 64) {
    const Scene scene = wave_box(packet, choice, height);
    Run<Real> run(scene);
    const double h = scene.cell, middle = 0.5 * scene.max[1], width = 1.5 * packet.cells * h;
    const double kx = packet.across > 0 ? 2 * pi / (packet.across * h) : 0, ky = 2 * pi / (packet.cells * h);
    const double k = std::hypot(kx, ky), c = speed_of(packet);
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        const double y = X[1] - middle;
        if (std::fabs(y) > width) return;
        const double size = 1e-4 * c * std::pow(std::cos(0.5 * pi * y / width), 2) * std::cos(kx * X[0] + ky * y);
        p.velocity[s][0] = static_cast<Real>(size * (packet.shear ? -ky : kx) / k);
        p.velocity[s][1] = static_cast<Real>(size * (packet.shear ? kx : ky) / k);
    });
    const double start = totals_of(run.sim).kinetic;
    const double away = (0.5 * scene.max[1] + width) / (c * ky / k);
    while (run.time() < 1.6 * away) run.steps(5);
    return 2 * totals_of(run.sim).strain / start;
}

}  // namespace moraine::verification
