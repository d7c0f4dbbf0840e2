// S25: the largest stable substep of a fluid whose pressure is the grid's, by bisection: by Poisson's ratio, by the
// most substeps of a step, and by what bounds the fluid. As in S1 all particles get a random velocity of 1e-9 c, and a
// substep is unstable if that grows more than a thousandfold in 2000 steps. h, c and rho are 1.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "core/error.hpp"
#include "stability/bisect.hpp"
#include "stability/cases.hpp"
#include "verification/problem_cloud.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double mach = 0.05;  ///< of what drifts
constexpr int steps = 2000;

/// A box of fluid, two particles per cell and axis.
struct Puddle {
    const char* name;
    double length, height;  ///< [cells]; length 16: all along the periodic axis
    bool floor, side;       ///< stands on a free-slip wall, and at one
    bool drifts;            ///< along x, and along y where there is no floor
};

constexpr Puddle shapes[] = {
    {"block", 6, 6, false, false, true},        {"film of 0.5 h", 16, 0.5, false, false, true},
    {"film of 2 h", 16, 2, false, false, true}, {"droplet", 1, 1, false, false, true},
    {"wall", 6, 4, true, false, true},          {"film on a wall", 16, 0.5, true, false, true},
    {"corner", 4, 4, true, true, false},
};

constexpr double ratios[] = {0.45, 0.48, 0.49, 0.495, 0.499, 0.4999};
constexpr int most[] = {1, 2, 4, 7, 10};
constexpr Transfer transfers[] = {Transfer::apic, Transfer::aflip};

Scene scene_of(const Puddle& shape, int dimensions, double nu, Transfer transfer) {
    Scene scene;
    scene.dimensions = dimensions;
    scene.cell = 1;
    scene.transfer = transfer;
    scene.flip = standard_flip(transfer);
    MaterialSpec fluid =
        material("newtonian", 1, {{"young", (1 + nu) * (1 - 2 * nu) / (1 - nu)}, {"poisson", nu}, {"viscosity", 0}});
    fluid.volumetric = Volumetric::grid;
    scene.materials = {fluid};
    BodySpec body;
    const double size[3] = {shape.length, shape.height, std::min(shape.length, 4.0)};
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimensions); ++a) {
        const bool closed = a == 1 ? shape.floor : a == 0 && shape.side;
        scene.max[a] = a == 2 ? 8 : 16;
        if (closed)
            scene.walls[a][0].kind = scene.walls[a][1].kind = WallKind::free_slip;
        else
            make_periodic(scene, a);
        body.min[a] = closed ? 0 : a == 0 && shape.length == 16 ? 0 : 3.1;
        body.max[a] = body.min[a] + size[a];
    }
    scene.bodies = {body};
    return scene;
}

template <int Dim>
bool is_stable(const Puddle& shape, const Scene& scene) {
    Run<double, Dim> run(scene);
    const double drift[3] = {shape.drifts ? 0.81 * mach : 0, shape.drifts && !shape.floor ? 0.5 * mach : 0, 0};
    run.start_with([&](const auto& p, std::uint32_t s, const auto&) {
        for (int a = 0; a < Dim; ++a) p.velocity[s][a] = drift[a] + cloud_perturbation * random_of(p.id[s], a);
    });
    double grown = 0;
    try {
        for (int done = 0; done < steps && grown < cloud_growth; done += 100) {
            run.steps(100);
            const double off = run.largest([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
                double all = 0;
                for (int a = 0; a < Dim; ++a) all = std::max(all, std::fabs(p.velocity[s][a] - drift[a]));
                return all;
            });
            grown = std::isfinite(off) ? off / cloud_perturbation : cloud_growth;
        }
    } catch (const PhysicsError&) {
        return false;
    }
    return grown < cloud_growth;
}

Finding limits_of(const std::string& name, const Puddle& shape, Scene scene) {
    Finding finding{name, {}, true, ""};
    const double asked = standard_courant(scene);
    double guess = 1;
    for (int substeps : most) {
        scene.substeps = substeps;
        const double limit = largest_stable(
            [&](double courant) {
                scene.cfl = courant;
                return scene.dimensions == 2 ? is_stable<2>(shape, scene) : is_stable<3>(shape, scene);
            },
            guess);
        guess = std::clamp(limit, 0.1, 1.5);
        finding.numbers.emplace_back(fmt::format("S = {}", substeps), limit);
        if (limit < asked) finding.pass = false, finding.why = fmt::format("below the default of {:.2g}", asked);
    }
    return finding;
}

}  // namespace

void find_substeps(const Wanted& wanted, const Report& report) {
    for (int dimensions : {2, 3})
        for (Transfer transfer : transfers)
            for (const Puddle& shape : shapes)
                for (double nu : ratios) {
                    const std::string name = fmt::format("{}-D {}, {}, nu {}", dimensions,
                                                         transfer == Transfer::apic ? "APIC" : "AFLIP", shape.name, nu);
                    if (!wanted.names(name) || (wanted.few && nu != 0.45 && nu != 0.495 && nu != 0.4999)) continue;
                    report(limits_of(name, shape, scene_of(shape, dimensions, nu, transfer)));
                }
}

}  // namespace moraine
