// S25: the largest stable substep of a fluid whose pressure is the grid's, by bisection: by Poisson's ratio, by the
// most substeps of a step, and by what bounds the fluid. As in S1 all particles get a random velocity of 1e-9 c, and a
// substep is unstable if that grows more than a thousandfold in 2000 steps. h, c and rho are 1.
//
// dt_L is the step that the program takes at the limit of S = 10: S of these substeps, or what the flow allows
// (core/courant.hpp), which below nu = 0.499 is less.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "core/data/error.hpp"
#include "core/fluid/grid_pressure.hpp"
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
    double size[3];          ///< [cells]
    bool along[3], wall[3];  ///< fills a periodic axis; stands at a free-slip wall across that axis
    bool drifts;             ///< along all axes without a wall
};

constexpr Puddle in_plane[] = {
    {"block", {6, 6}, {}, {}, true},
    {"film of 0.5 h", {16, 0.5}, {true}, {}, true},
    {"film of 2 h", {16, 2}, {true}, {}, true},
    {"film of 3 h", {16, 3}, {true}, {}, true},
    {"droplet", {1, 1}, {}, {}, true},
    {"particle", {0.5, 0.5}, {}, {}, true},
    {"wall", {6, 4}, {}, {false, true}, true},
    {"film on a wall", {16, 0.5}, {true}, {false, true}, true},
    {"particle at a wall", {0.5, 0.5}, {}, {false, true}, true},
    {"corner", {4, 4}, {}, {true, true}, false},
    {"particle in a corner", {0.5, 0.5}, {}, {true, true}, false},
};

constexpr Puddle in_space[] = {
    {"block", {6, 6, 6}, {}, {}, true},
    {"film of 0.5 h", {8, 0.5, 4}, {true, false, true}, {}, true},
    {"film of 1 h", {8, 1, 4}, {true, false, true}, {}, true},
    {"film of 2 h", {8, 2, 4}, {true, false, true}, {}, true},
    {"film of 3 h", {8, 3, 4}, {true, false, true}, {}, true},
    {"film of 6 h", {4, 6, 4}, {true, false, true}, {}, true},
    {"droplet", {1, 1, 1}, {}, {}, true},
    {"particle", {0.5, 0.5, 0.5}, {}, {}, true},
    {"wall", {4, 4, 4}, {true, false, true}, {false, true}, true},
    {"film on a wall", {8, 0.5, 4}, {true, false, true}, {false, true}, true},
    {"particle at a wall", {0.5, 0.5, 0.5}, {}, {false, true}, true},
    {"edge", {4, 4, 4}, {false, false, true}, {true, true}, false},
    {"corner", {4, 4, 4}, {}, {true, true, true}, false},
    {"particle in a corner", {0.5, 0.5, 0.5}, {}, {true, true, true}, false},
};

constexpr double ratios[] = {0.45, 0.49, 0.495, 0.499, 0.4999};
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
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimensions); ++a) {
        scene.max[a] = shape.along[a] ? shape.size[a] : dimensions == 2 ? 16 : 12;
        if (shape.wall[a])
            scene.walls[a][0].kind = scene.walls[a][1].kind = WallKind::free_slip;
        else
            make_periodic(scene, a);
        body.min[a] = shape.wall[a] || shape.along[a] ? 0 : 3.1;
        body.max[a] = body.min[a] + shape.size[a];
    }
    scene.bodies = {body};
    return scene;
}

template <int Dim>
bool is_stable(const Puddle& shape, const Scene& scene) {
    Run<double, Dim> run(scene);
    constexpr double direction[3] = {0.81, 0.5, 0.305};
    double drift[Dim];
    for (int a = 0; a < Dim; ++a) drift[a] = shape.drifts && !shape.wall[a] ? mach * direction[a] : 0;
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

/// dt c / h of the program where dts c / h is `courant`, of a fluid with this Poisson's ratio.
double whole_step(Scene scene, double courant, double nu) {
    scene.cfl = courant;
    return choose_step(scene, 1, 0, std::sqrt((0.5 - nu) / (1 - nu))).dt;
}

Finding limits_of(const std::string& name, const Puddle& shape, double nu, Scene scene) {
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
        if (substeps == most_substeps) finding.numbers.emplace_back("dt_L", whole_step(scene, limit, nu));
    }
    return finding;
}

}  // namespace

void find_substeps(const Wanted& wanted, const Report& report) {
    const auto find = [&](int dimensions, const auto& shapes) {
        for (Transfer transfer : transfers)
            for (const Puddle& shape : shapes)
                for (double nu : ratios) {
                    const std::string name = fmt::format("{}-D {}, {}, nu {}", dimensions,
                                                         transfer == Transfer::apic ? "APIC" : "AFLIP", shape.name, nu);
                    if (!wanted.names(name) || (wanted.few && nu != 0.45 && nu != 0.495 && nu != 0.4999)) continue;
                    report(limits_of(name, shape, nu, scene_of(shape, dimensions, nu, transfer)));
                }
    };
    find(2, in_plane);
    find(3, in_space);
}

}  // namespace moraine
