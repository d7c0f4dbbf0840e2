// S26: fluids whose cures are on (pressure smoothing, particle shifting, pressures on the grid, substeps) in a motion
// of 1000 periods that must not gain energy, and in one of ten turns that must keep its angular momentum.
//
// The bar is that of S6 with a fluid without viscosity and yield stress in it, K = 100 Pa for E, 2 x 2 particles per
// cell: a sound wave. Its sides are periodic, and adrift its ends are. At rest it has a wall at one end and a surface
// at the other; it bears tension, having no yield in it, and no side for it to contract at.
//
// A fluid without strength does not turn as a square; what turns is a Bingham fluid below its yield stress, which takes
// all cures. At 0.45 of Poisson's ratio it bears substeps.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "stability/cases.hpp"
#include "stability/cures.hpp"
#include "verification/problem_bar.hpp"
#include "verification/problem_rotation.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr int cells_per_wave = 64;
constexpr double growth_goal = 1.01;    ///< of the energy over its least before, in 1000 periods
constexpr double motion_goal = 2;       ///< of the kinetic energy alone, whose mean over a period is less sharp
constexpr double least_energy = 1e-8;   ///< E / E0: below is what stays of strains of second order
constexpr double least_motion = 1e-18;  ///< E / E0: below is rounding
constexpr double most_energy = 1e7;     ///< E / E0 that is said where it has grown beyond doubt
constexpr double lost_signal = 1.2;     ///< c + |v| over c
constexpr double momentum_goal = 0.01;
constexpr Spin square{.drift = 0.018};
constexpr double young = 1e5, poisson = 0.45, square_cell = 0.1;  ///< of the square [Pa], [-], [m]

struct FluidBars {
    const char* name;
    const Motion& motion;
    double share;  ///< of the program's step
};

const FluidBars bars[] = {
    {"bar at rest", faint_free_end, 1},
    {"bar adrift", faint_adrift, 1},
    {"bar at rest, half of the step", faint_free_end, 0.5},
    {"bar adrift, half of the step", faint_adrift, 0.5},
};

Scene fluid_bar(const Bar& bar, const Choice& method, const FluidBars& story, const Cure& cure) {
    Scene scene = bar_scene(bar, method, story.motion, cells_per_wave, 1);
    const double nu = 0.495;
    scene.materials = {material("newtonian", bar.density,
                                {{"young", 3 * bar.young * (1 - 2 * nu)}, {"poisson", nu}, {"viscosity", 0}})};
    scene.bodies[0].particles_per_cell = {2, 2, 1};
    scene.dt = 0;
    scene.cfl = story.share * standard_courant(scene);
    cure_fluid(scene, cure);
    return scene;
}

/// Energies over E0.
struct Loudness {
    double all, motion;
};

/// Of what is left of the wave, mean over the period that ends at a moment [s]. None when it has grown beyond doubt:
/// steps become short then, and the moment does not come.
Loudness loudness_at(Run<>& run, const Bar& bar, double moment, double drift, double volume) {
    double strain = 0, motion = 0;
    int looks = 0;
    while (run.time() < moment) {
        run.steps(1);
        if (run.sim.clock().signal > lost_signal * bar.wave_speed()) return {INFINITY, INFINITY};
        if (run.time() <= moment - bar.period()) continue;
        strain += totals_of(run.sim).strain;
        motion += run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
            const double u = p.velocity[s][0] - drift, v = p.velocity[s][1];
            return 0.5 * p.mass[s] * (u * u + v * v);
        });
        ++looks;
    }
    const double whole = looks * bar.energy(volume);
    return {(strain + motion) / whole, motion / whole};
}

/// By how much an energy rises above its least before, and how fast.
struct Rise {
    double floor;
    double least = 1, factor = 1, rate = 0;  ///< [-], [-], [1/period]
    int since = 0;

    void look(int periods, double energy) {
        const double now = std::isfinite(energy) ? std::max(energy, floor) : most_energy;
        if (now > factor * least) factor = now / least, rate = std::log(factor) / (periods - since);
        if (now < least) least = now, since = periods;
    }
};

void judge(Finding& finding, const Rise& all, const Rise& motion) {
    finding.numbers.emplace_back("energy rises to times its least", all.factor);
    finding.numbers.emplace_back("kinetic rises to times its least", motion.factor);
    finding.pass = all.factor <= growth_goal && motion.factor <= motion_goal;
    if (*finding.pass) return;
    const Rise& worse = all.factor <= growth_goal ? motion : all;
    finding.why = fmt::format("{}energy grows by {:.2g} of itself in a period, to {:.2g} times its least",
                              &worse == &motion ? "kinetic " : "", worse.rate, worse.factor);
}

/// Looks every 50 periods, so that what grows after it was damped is seen.
void ring_fluid(Finding& finding, const FluidBars& story, const Choice& method, const Cure& cure) {
    const Bar bar{.speed = story.motion.speed};
    const Scene scene = fluid_bar(bar, method, story, cure);
    Run<> run(scene);
    pluck(run, bar, story.motion.drift);
    run.steps(1);
    finding.numbers.emplace_back("dt c / h", run.time() * bar.wave_speed() / scene.cell);
    const double volume = (story.motion.periodic ? 4 : 1) * bar.length * scene.max[1];
    Rise all{least_energy}, motion{least_motion};
    for (int periods = 50; periods <= 1000; periods += 50) {
        const Loudness now = loudness_at(run, bar, periods * bar.period(), story.motion.drift, volume);
        if (periods == 100 || periods == 1000)
            finding.numbers.emplace_back(fmt::format("E / E0 after {} periods", periods), now.all);
        all.look(periods, now.all);
        motion.look(periods, now.motion);
        if (!std::isfinite(now.all)) break;
    }
    judge(finding, all, motion);
}

/// Sum m |x - x_c|^2 [kg m2].
double inertia(Run<>& run) {
    const auto totals = totals_of(run.sim);
    const double x = totals.centre[0] / totals.mass, y = totals.centre[1] / totals.mass;
    return run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto& at) {
        return p.mass[s] * (std::pow(at[0] - x, 2) + std::pow(at[1] - y, 2));
    });
}

/// Where it keeps L and not E the square has swollen or shrunk, which its moment of inertia I says.
void turn_fluid(Finding& finding, double share, const Choice& method, const Cure& cure) {
    Scene scene = spin_scene(square, method, square_cell, young);
    scene.materials = {material("bingham", square.density,
                                {{"young", young}, {"poisson", poisson}, {"viscosity", 0}, {"yield_stress", 1e9}})};
    scene.cfl = share * standard_courant(scene);
    cure_fluid(scene, cure);
    const double D = affine_moment(scene);
    Run<> run(scene);
    turn(run, square);
    const double momentum = angular_momentum(run, D)[1], energy = spin_energy(run, D);
    const double extent = inertia(run);
    while (run.time() < 2 * pi / square.rate * 10) run.steps(20);
    const double kept = angular_momentum(run, D)[1] / momentum;
    finding.numbers.emplace_back("L / L0 after 10 turns", kept);
    finding.numbers.emplace_back("E / E0 after 10 turns", spin_energy(run, D) / energy);
    finding.numbers.emplace_back("I / I0 after 10 turns", inertia(run) / extent);
    finding.pass = std::fabs(kept - 1) <= momentum_goal;
    if (!*finding.pass) finding.why = fmt::format("{:.3g} of the angular momentum after 10 turns", kept);
}

}  // namespace

void drift_fluids(const Wanted& wanted, const Report& report) {
    const auto tell_of = [&](const std::string& story, const auto& measure) {
        for (const Cure& cure : cures)
            for (const Choice& method : cured_methods) {
                Finding finding{fmt::format("{}: {}, {}", story, method.name, cure.name), {}, false, ""};
                if (!wanted.names(finding.configuration)) continue;
                attempt(finding, [&] { measure(finding, method, cure); });
                report(finding);
            }
    };
    for (const FluidBars& story : bars)
        tell_of(story.name, [&](Finding& finding, const Choice& method, const Cure& cure) {
            ring_fluid(finding, story, method, cure);
        });
    for (const auto& [name, share] :
         {std::pair{"square that turns", 1.0}, {"square that turns, half of the step", 0.5}})
        tell_of(name, [&, share = share](Finding& finding, const Choice& method, const Cure& cure) {
            turn_fluid(finding, share, method, cure);
        });
}

}  // namespace moraine
