// S17: steps that follow the program's rule, and steps that jump below it as a saw does, against fixed fine steps.
//
// The rule takes the speeds of the state before the step. What they are after it says how much of the method's stable
// step (core/courant.hpp) it was: dt (c + |v|) / h over the limit, the larger of before and after. The rule's own share
// is 0.8. As many fixed steps as the rule's say how much of a difference is that of their size, not of their change.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "stability/cases.hpp"
#include "verification/problem_flow.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double goal = 0.002;      ///< of the result
constexpr double share_goal = 0.9;  ///< of the stable step
constexpr int tooth = 50;           ///< steps from the least share to the whole
constexpr double least = 0.2;       ///< share of the rule's step
constexpr double finer = 4;         ///< fixed steps: the rule's least over this

/// A rubber column (neo-hookean, k l0 = 0.4) under gravity that is there at once: it gets shorter by 15 % and stiffer.
Scene column_scene(const Choice& choice) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 0.25;
    scene.max = {1, 10, 0};
    scene.end = 5;
    choose(scene, choice);
    scene.cfl = standard_courant(scene);
    scene.gravity = {0, -10, 0};
    make_periodic(scene, 0);
    scene.walls[1][0].kind = WallKind::free_slip;
    scene.materials.push_back(material("neo-hookean", 1000, {{"young", 2e5}, {"poisson", 0.0}}));
    BodySpec body;
    body.max = {1, 8, 0};
    body.particles_per_cell = {1, 2, 1};
    scene.bodies.push_back(body);
    return scene;
}

struct Story {
    const char* name;
    Scene (*scene)(const Choice&);
    int axis;         ///< of the result, the way of the centre of mass
    double until;     ///< [s]
    double wave = 0;  ///< speed at the start, where all falls at once: v is given at -dt / 2 [m/s]
};

// The column is looked at before its first turn, where its centre is fast.
const Story stories[] = {
    {"column under sudden gravity, 0.6 s", column_scene, 1, 0.6, std::sqrt(200.0)},
    {"SEED-1, H0 / 20, 4 s", [](const Choice& c) { return slurry_scene(c, 20); }, 0, 4},
    {"R8, a = 2, L0 / 10, 0.86 s", [](const Choice& c) { return sand_scene(c, 10, WallKind::friction); }, 0, 0.86},
};

struct Followed {
    double way = NAN;                       ///< of the centre of mass [m]
    double share = 0;                       ///< largest, of the stable step
    double least_dt = INFINITY, steps = 0;  ///< [s]
};

enum class Steps { rule, saw, fixed };

double centre(Simulation<double, 2>& sim, int axis) {
    const Totals<2> all = totals_of(sim);
    return all.centre[static_cast<std::size_t>(axis)] / all.mass;
}

Followed follow(const Story& story, Scene scene, Steps kind, double fixed) {
    const double whole = scene.cfl, limit = stable_courant(scene.shape, scene.transfer, scene.stress_update);
    const double first =
        kind == Steps::fixed ? fixed : (kind == Steps::saw ? least : 1) * whole * scene.cell / story.wave;
    if (story.wave > 0)
        for (std::size_t a = 0; a < 2; ++a) scene.bodies[0].velocity[a] = -0.5 * scene.gravity[a] * first;
    const Comm comm(MPI_COMM_WORLD);
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    const double began = centre(sim, story.axis);
    Followed out;
    for (int k = 0; story.until - sim.clock().time > 1e-9 * story.until; ++k) {
        const double left = story.until - sim.clock().time, before = sim.clock().signal;
        if (kind == Steps::saw) scene.cfl = whole * (least + (1 - least) * (k % tooth) / (tooth - 1));
        const double next = kind == Steps::fixed ? fixed : scene.cfl * scene.cell / before;
        scene.dt = next >= left ? left : (kind == Steps::fixed ? fixed : 0);
        sim.step(), sim.balance(), sim.conclude();
        out.share = std::max(out.share, sim.clock().dt * std::max(before, sim.clock().signal) / scene.cell / limit);
        if (next < left) out.least_dt = std::min(out.least_dt, sim.clock().dt);
        ++out.steps;
    }
    out.way = centre(sim, story.axis) - began;
    return out;
}

void compare(Finding& finding, const Story& story, const Choice& choice) {
    const Scene scene = story.scene(choice);
    const Followed rule = follow(story, scene, Steps::rule, 0), saw = follow(story, scene, Steps::saw, 0);
    const Followed fine = follow(story, scene, Steps::fixed, rule.least_dt / finer);
    const Followed same = follow(story, scene, Steps::fixed, story.until / rule.steps);
    const double off = rule.way / fine.way - 1, saw_off = saw.way / fine.way - 1;
    finding.numbers = {{"steps by the rule", rule.steps},
                       {"steps of the saw", saw.steps},
                       {"fixed fine steps", fine.steps},
                       {"share of the stable step, rule", rule.share},
                       {"saw", saw.share},
                       {"way of the centre [m]", fine.way},
                       {"off by the rule", off},
                       {"off by the saw", saw_off},
                       {"off by as many fixed steps as the rule's", same.way / fine.way - 1}};
    if (std::max(rule.share, saw.share) > share_goal) finding.why += "a step is above 0.9 of the stable one; ";
    if (!(std::fabs(off) <= goal)) finding.why += fmt::format("the rule's steps are off by {:.1e}; ", off);
    if (!(std::fabs(saw_off) <= goal)) finding.why += fmt::format("the saw's are off by {:.1e}; ", saw_off);
    finding.pass = finding.why.empty();
}

}  // namespace

void vary_steps(const Wanted& wanted, const Report& report) {
    tell(wanted, report, stories, {quadratic_flip_usl, quadratic_apic_usl, quadratic_apic_musl}, compare);
}

}  // namespace moraine
