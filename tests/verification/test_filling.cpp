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
