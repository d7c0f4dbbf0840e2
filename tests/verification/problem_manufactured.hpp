#pragma once
// E3 as a run: the manufactured displacement over one period, periodic over [0, 2] or between walls over [0, 1]; the
// largest of 16 looks at its error.

#include <algorithm>

#include "verification/exact_manufactured.hpp"
#include "verification/run.hpp"

namespace moraine::verification {

struct Deviation {
    double displacement = 0;  ///< rms over A, largest over one period
    double stress = 0;        ///< rms at that time over E A pi
};

/// Square or (one moving axis) a strip: over [0, 2] periodic, or over [0, 1] between walls.
inline Scene square(const Manufactured& exact, int cells_per_wave, const Choice& choice, bool periodic, double cfl) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 2.0 / cells_per_wave;
    const double side = periodic ? 2 : 1;
    scene.max = {side, exact.axes == 2 ? side : 4 * scene.cell, 0};
    choose(scene, choice);
    for (std::size_t a = 0; a < 2; ++a) {
        if (periodic || static_cast<int>(a) >= exact.axes)
            make_periodic(scene, a);
        else
            scene.walls[a][0].kind = scene.walls[a][1].kind = WallKind::free_slip;
    }
    const double modulus = exact.lambda() + 2 * exact.mu();
    scene.dt = cfl * scene.cell / std::sqrt(modulus / exact.density);
    scene.materials.push_back(
        material("neo-hookean", exact.density, {{"young", exact.young}, {"poisson", exact.poisson}}));
    BodySpec body;
    body.max = scene.max;
    if (exact.axes == 1) body.particles_per_cell[1] = 1;
    scene.bodies.push_back(body);
    return scene;
}

/// The exact state at t = 0, with the velocity of half a step before; USF needs the stress of a whole one before.
template <class Real>
void start(Run<Real>& run, const Manufactured& exact) {
    const Scene& scene = run.sim.scene();
    const double half = -scene.dt / 2;
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        for (int a = 0; a < 2; ++a) {
            const double x = X[static_cast<std::size_t>(a)];
            p.velocity[s][a] = static_cast<Real>(exact.velocity(a, x, half));
            if (p.affine) p.affine[s](a, a) = static_cast<Real>(exact.stretch_rate(a, x, half));
        }
        if (scene.stress_update != StressUpdate::usf) return;
        double J = 1;
        for (int a = 0; a < 2; ++a) {
            const double F = exact.stretch(a, X[static_cast<std::size_t>(a)], 2 * half);
            p.left_stretch[s][a] = static_cast<Real>(F * F - 1);
            p.stress[s][a] = static_cast<Real>(exact.stress(a, X, 2 * half));
            J *= F;
        }
        p.ln_J[s] = static_cast<Real>(std::log(J));
        p.volume[s] *= static_cast<Real>(J);
    });
}

template <class Real>
Deviation deviation(Run<Real>& run, const Manufactured& exact) {
    const Scene& scene = run.sim.scene();
    const double t = run.time();
    Deviation e;
    const auto count = static_cast<double>(run.particles());
    e.displacement = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
        double square = 0;
        for (std::size_t a = 0; a < 2; ++a) {
            const double error = x[a] - X[a] - exact.displacement(static_cast<int>(a), X[a], t);
            square += std::pow(std::remainder(error, scene.max[a]), 2);
        }
        return square;
    });
    e.stress = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
        double square = 0;
        for (int a = 0; a < exact.axes; ++a) square += std::pow(p.stress[s](a, a) - exact.stress(a, X, t), 2);
        return square;
    });
    e.displacement = std::sqrt(e.displacement / count) / exact.amplitude;
    e.stress = std::sqrt(e.stress / count) / (exact.young * exact.amplitude * pi);
    return e;
}

/// Acceleration of the body force at (X, t).
inline std::function<Vec<double, 2>(const std::array<double, 2>&, double)> push(const Manufactured& exact) {
    return [exact](const auto& X, double t) {
        return Vec<double, 2>{{exact.body_force(0, X, t), exact.body_force(1, X, t)}};
    };
}

/// Of a run made with push(exact).
template <class Real>
Deviation manufacture(Run<Real>& run, const Manufactured& exact) {
    start(run, exact);
    Deviation worst;
    const auto steps = static_cast<int>(std::lround(exact.period() / run.sim.scene().dt));
    for (int part = 1; part <= 16; ++part) {
        run.steps(steps * part / 16 - steps * (part - 1) / 16);
        const Deviation now = deviation(run, exact);
        worst.displacement = std::max(worst.displacement, now.displacement);
        worst.stress = std::max(worst.stress, now.stress);
    }
    return worst;
}

}  // namespace moraine::verification
