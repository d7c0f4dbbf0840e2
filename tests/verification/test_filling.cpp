// What becomes of the space between particles: a slurry that runs out crowds them, and shifting keeps them apart.
#include "records/time_series.hpp"
#include "verification/drive.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

/// inputs/slurry_runout.toml at `level` cells of its height, to 8 s.
Scene runout(int level, Transfer transfer, double smoothing, double shifting) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 5.0 / level;
    scene.max = {80, 7.5, 0};
    scene.gravity = {0, -9.81, 0};
    scene.walls[0][0].kind = WallKind::free_slip;
    scene.walls[1][0].kind = WallKind::no_slip;
    scene.walls[0][1].kind = WallKind::open;
    scene.transfer = transfer;
    scene.flip = standard_flip(transfer);
    scene.end = 8;
    scene.materials = {
        material("bingham", 1500, {{"young", 2.5e5}, {"poisson", 0.495}, {"viscosity", 50}, {"yield_stress", 500}})};
    scene.materials[0].pressure_smoothing = smoothing;
    scene.materials[0].particle_shifting = shifting;
    BodySpec body;
    body.max = {10, 5, 0};
    body.geostatic = true;
    body.geostatic_surface = 5;
    scene.bodies = {body};
    return scene;
}

/// 1 m x 0.5 m of fluid in a tank with smooth walls, pushed aside by 0.1 m/s, which sloshes for 8 s.
Scene tank(Transfer transfer) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 1.0 / 16;
    scene.max = {1, 0.75, 0};
    scene.gravity = {0, -9.81, 0};
    for (auto [axis, side] : {std::pair{0, 0}, {0, 1}, {1, 0}})
        scene.walls[std::size_t(axis)][std::size_t(side)].kind = WallKind::free_slip;
    scene.transfer = transfer;
    scene.flip = standard_flip(transfer);
    scene.end = 8;
    scene.materials = {material("newtonian", 1000, {{"young", 1.9e4}, {"poisson", 0.495}, {"viscosity", 5}})};
    scene.materials[0].pressure_smoothing = 0.22;
    scene.materials[0].particle_shifting = 0.3;
    BodySpec body;
    body.max = {1, 0.5, 0};
    body.velocity = {0.1, 0, 0};
    body.geostatic = true;
    body.geostatic_surface = 0.5;
    scene.bodies = {body};
    return scene;
}

struct Outcome {
    double over_filling;    ///< at 8 s
    double front;           ///< 99.5 % of the volume are behind it [m]
    double momentum_error;  ///< of M c
};

Outcome run_out(const Scene& scene) {
    const Comm comm(MPI_COMM_WORLD);
    Run<> run(scene);
    while (run.time() < scene.end) run.steps(1);
    const TimeSeriesRow<2> row = observe(run.sim, comm);
    std::vector<double> x;
    each_particle(run.sim, [&](std::uint32_t, const auto& at) { x.push_back(at[0]); });
    std::sort(x.begin(), x.end());
    const Outcome out{row.over_filling, x[static_cast<std::size_t>(0.995 * static_cast<double>(x.size()))],
                      std::fabs(row.momentum_error[0]) / (row.totals.mass * run.sim.clock().signal)};
    say(fmt::format("slurry at 8 s: over-filling {:.2f} %, front {:.2f} m", 100 * out.over_filling, out.front));
    return out;
}

}  // namespace

TEST_CASE(
    "a slurry that runs out over-fills its nodes by more than 1 %, and with smoothing and shifting by less than "
    "0.5 %") {
    const Outcome plain = run_out(runout(10, Transfer::apic, 0, 0));
    CHECK(plain.over_filling > 0.01);
    for (Transfer transfer : {Transfer::apic, Transfer::aflip}) {
        CAPTURE(int(transfer));
        const Outcome shifted = run_out(runout(10, transfer, 0.22, 0.1));
        CHECK(shifted.over_filling < 0.005);
        CHECK(shifted.momentum_error < 1e-13);
    }
}

TEST_CASE("a tank that sloshes keeps its depth with smoothing and shifting") {
    const Comm comm(MPI_COMM_WORLD);
    for (Transfer transfer : {Transfer::apic, Transfer::aflip}) {
        CAPTURE(int(transfer));
        const Scene scene = tank(transfer);
        Run<> run(scene);
        double over_filling = 0;
        while (run.time() < scene.end) {
            run.steps(200);
            over_filling = std::max(over_filling, observe(run.sim, comm).over_filling);
        }
        const Totals<2> totals = totals_of(run.sim);
        const double height = totals.centre[1] / totals.mass;
        say(fmt::format("tank after 8 s: centre of mass {:+.2f} %, over-filling at most {:.2f} %",
                        100 * (height / 0.25 - 1), 100 * over_filling));
        CHECK(std::fabs(height / 0.25 - 1) < 0.005);
        CHECK(over_filling < 0.005);
    }
}
