#pragma once
// E7 as a run: a free square that turns and drifts; its angular momentum and energy.

#include "verification/exact_rotation.hpp"
#include "verification/run.hpp"

namespace moraine::verification {

inline Scene spin_scene(const Spin& spin, const Choice& choice, double cell, double young) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = cell;
    scene.max = {14, 14, 0};
    choose(scene, choice);
    scene.cfl = 0.4;
    scene.materials.push_back(material("linear-elastic", spin.density, {{"young", young}, {"poisson", 0.3}}));
    BodySpec body;
    body.min = {1, 1, 0};
    body.max = {1 + spin.side, 1 + spin.side, 0};
    scene.bodies.push_back(body);
    return scene;
}

inline void turn(Run<>& run, const Spin& spin) {
    const double centre = 1 + spin.side / 2;
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        p.velocity[s][0] = spin.drift - spin.rate * (X[1] - centre);
        p.velocity[s][1] = spin.drift + spin.rate * (X[0] - centre);
        if (p.affine) p.affine[s](0, 1) = -spin.rate, p.affine[s](1, 0) = spin.rate;
    });
}

/// D of the affine part, per mass [m2]; that of the quadratic spline for gimp too, whose own varies with the place.
inline double affine_moment(const Scene& scene) {
    return scene.cell * scene.cell / (scene.shape == Shape::cubic ? 3 : 4);
}

/// Angular momentum about the domain's corner: of the particles, and with the affine part.
inline std::array<double, 2> angular_momentum(Run<>& run, double D) {
    const double particles = run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto& x) {
        return p.mass[s] * (x[0] * p.velocity[s][1] - x[1] * p.velocity[s][0]);
    });
    const double affine = run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
        return p.affine ? p.mass[s] * D * (p.affine[s](1, 0) - p.affine[s](0, 1)) : 0;
    });
    return {particles, particles + affine};
}

/// Kinetic, affine part included, and elastic [J].
inline double spin_energy(Run<>& run, double D) {
    const auto totals = totals_of(run.sim);
    return totals.kinetic + totals.strain + run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
        double square = 0;
        for (int a = 0; p.affine && a < 2; ++a)
            for (int b = 0; b < 2; ++b) square += p.affine[s](a, b) * p.affine[s](a, b);
        return 0.5 * p.mass[s] * D * square;
    });
}

}  // namespace moraine::verification
