#pragma once
// E4 as a run: the ring in a square that is at rest; the largest of 16 looks at the places of its particles. dt follows
// the present stretch, which makes a sheared body several times as stiff along its extension.

#include <algorithm>

#include "verification/exact_vortex.hpp"
#include "verification/run.hpp"

namespace moraine::verification {

/// `cells` per metre.
inline Scene vortex_scene(const Vortex& exact, int cells, const Choice& choice, double cfl) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 1.0 / cells;
    scene.min = {-1.5, -1.5, 0};
    scene.max = {1.5, 1.5, 0};
    for (std::size_t a = 0; a < 2; ++a) scene.walls[a][0].kind = scene.walls[a][1].kind = WallKind::no_slip;
    choose(scene, choice);
    scene.cfl = cfl;
    scene.end = exact.end;
    scene.materials.push_back(
        material("neo-hookean", exact.density, {{"young", exact.young}, {"poisson", exact.poisson}}));
    BodySpec body;
    body.min = scene.min, body.max = scene.max;
    scene.bodies.push_back(body);
    return scene;
}

inline std::function<Vec<double, 2>(const std::array<double, 2>&, double)> push(const Vortex& exact) {
    return [exact](const auto& X, double t) {
        const auto b = exact.body_force(X, t);
        return Vec<double, 2>{{b[0], b[1]}};
    };
}

/// Largest rms error of places in the ring [m]; of a run made with push(exact).
template <class Real>
double turn(Run<Real>& run, const Vortex& exact) {
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        const auto [spin, slope] = exact.spin(X);
        p.velocity[s][0] = static_cast<Real>(-spin * X[1]);
        p.velocity[s][1] = static_cast<Real>(spin * X[0]);
        if (!p.affine) return;
        const double R = Vortex::radius(X);
        for (int b = 0; b < 2; ++b) {
            const double along = slope * X[static_cast<std::size_t>(b)] / R;
            p.affine[s](0, b) = static_cast<Real>(-X[1] * along - (b == 1 ? spin : 0));
            p.affine[s](1, b) = static_cast<Real>(X[0] * along + (b == 0 ? spin : 0));
        }
    });
    const double ring =
        run.sum([](const auto&, std::uint32_t, const auto& X, const auto&) { return Vortex::in_ring(X); });
    double worst = 0;
    for (int look = 1; look <= 16; ++look) {
        while (run.time() < exact.end * look / 16) run.steps(1);
        const double t = run.time();
        const double square = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
            const auto at = exact.place(X, t);
            return Vortex::in_ring(X) ? std::pow(x[0] - at[0], 2) + std::pow(x[1] - at[1], 2) : 0.0;
        });
        worst = std::max(worst, std::sqrt(square / ring));
    }
    return worst;
}

}  // namespace moraine::verification
