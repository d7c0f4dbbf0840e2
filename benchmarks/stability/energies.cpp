// S16: where the energy of a run goes: motion, elastic energy, dissipation by the laws, and what the transfers took.
//
// The last is what is missing of the energy that the run had at its start, by the program's own budget; there is no
// second account of it, so the sum of all closes by its making, and the share is what is looked at. Nothing else is in
// it: these scenes have no friction on walls, no structures, no damping, and nothing leaves.

#include <fmt/format.h>

#include <cmath>

#include "core/courant.hpp"
#include "records/time_series.hpp"
#include "stability/cases.hpp"
#include "verification/problem_flow.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double goal = 0.05;          ///< of what the laws dissipate
constexpr double elastic_goal = 0.01;  ///< of the energy, where no law dissipates (E12)

/// E12: two elastic disks meet in the middle of a square (Sulsky et al. 1994).
Scene disks_scene(const Choice& choice) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 0.05;
    scene.max = {1, 1, 0};
    scene.end = 3.5;
    choose(scene, choice);
    scene.cfl = standard_courant(scene);
    scene.materials.push_back(material("neo-hookean", 1000, {{"young", 1000}, {"poisson", 0.3}}));
    for (double side : {0.2, 0.8}) {
        BodySpec disk;
        disk.shape = BodyShape::sphere;
        disk.center = {side, side, 0};
        disk.radius = 0.2;
        const double v = side < 0.5 ? 0.1 : -0.1;
        disk.velocity = {v, v, 0};
        scene.bodies.push_back(disk);
    }
    return scene;
}

Scene averaged(Scene scene) {
    scene.materials[0].volumetric = Volumetric::cell;
    return scene;
}

struct Story {
    const char* name;
    Scene (*scene)(const Choice&);
    bool dissipates;
};

constexpr Story stories[] = {
    {"SEED-1, 20 s, H0 / 20", [](const Choice& c) { return slurry_scene(c, 20); }, true},
    {"SEED-1, 20 s, H0 / 20, means of cells", [](const Choice& c) { return averaged(slurry_scene(c, 20)); }, true},
    {"R8, a = 2, L0 / 10, no slip", [](const Choice& c) { return sand_scene(c, 10, WallKind::no_slip); }, true},
    {"R4, 30 s, H0 / 10", [](const Choice& c) { return current_scene(c, 10); }, true},
    {"E12, disks, 3.5 s", disks_scene, false},
};

void account(Finding& finding, const Story& story, const Choice& choice) {
    const Scene scene = story.scene(choice);
    const Comm comm(MPI_COMM_WORLD);
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    const TimeSeriesRow<2> start = observe(sim, comm);
    while (sim.clock().time < scene.end) sim.step(), sim.balance();
    sim.conclude();
    const TimeSeriesRow<2> end = observe(sim, comm);
    const double had = start.potential - end.potential + start.totals.kinetic + start.totals.strain;
    const double share = end.unaccounted / (story.dissipates ? end.dissipated : had);
    finding.numbers = {{"kinetic", end.totals.kinetic / had},
                       {"elastic", end.totals.strain / had},
                       {"dissipated by laws", end.dissipated / had},
                       {"by transfers", end.unaccounted / had},
                       {"by transfers / by laws", story.dissipates ? share : NAN}};
    finding.pass = std::fabs(share) <= (story.dissipates ? goal : elastic_goal);
    if (!*finding.pass)
        finding.why = fmt::format("the transfers {} {:.1f} % of {}", share > 0 ? "take" : "give",
                                  100 * std::fabs(share), story.dissipates ? "what the laws take" : "the energy");
}

}  // namespace

void keep_accounts(const Wanted& wanted, const Report& report) {
    tell(wanted, report, stories, {quadratic_flip_usl, quadratic_apic_usl, quadratic_tpic_usl, gimp_flip_usl}, account);
}

}  // namespace moraine
