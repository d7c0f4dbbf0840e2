// Pressures on cells of the grid, with and without substeps: what rests stays at rest, momentum is exact, a runout ends
// where it ended, and a thin film on a wall stands.
#include "records/time_series.hpp"
#include "verification/drive.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

Scene fluid(double cell, int substeps, double viscosity, double yield_stress) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = cell;
    scene.gravity = {0, -9.81};
    scene.cfl = 0.5;
    scene.substeps = substeps;
    for (auto [axis, side] : {std::pair{0, 0}, {0, 1}, {1, 0}})
        scene.walls[std::size_t(axis)][std::size_t(side)].kind = WallKind::free_slip;
    scene.materials = {
        material("bingham", 1500,
                 {{"young", 2.5e5}, {"poisson", 0.495}, {"viscosity", viscosity}, {"yield_stress", yield_stress}})};
    scene.materials[0].volumetric = Volumetric::grid;
    scene.materials[0].pressure_smoothing = 0.22;
    scene.materials[0].particle_shifting = 0.2;
    return scene;
}

BodySpec block(double length, double height) {
    BodySpec body;
    body.max = {length, height, 0};
    body.geostatic = true;
    body.geostatic_surface = height;
    return body;
}

double front_of(Run<>& run) {
    std::vector<double> x;
    each_particle(run.sim, [&](std::uint32_t, const auto& at) { x.push_back(at[0]); });
    std::sort(x.begin(), x.end());
    return x[static_cast<std::size_t>(0.995 * static_cast<double>(x.size()))];
}

}  // namespace

TEST_CASE("a fluid at rest in a tank keeps its depth and stays at rest") {
    for (int substeps : {1, 10}) {
        CAPTURE(substeps);
        Scene scene = fluid(1.0 / 16, substeps, 1, 0);
        scene.max = {1, 0.75, 0};
        scene.bodies = {block(1, 0.5)};
        scene.end = 1.5;
        Run<> run(scene);
        while (run.time() < scene.end) run.steps(1);
        const Totals<2> totals = totals_of(run.sim);
        const double height = totals.centre[1] / totals.mass, potential = totals.mass * 9.81 * 0.25;
        say(fmt::format("at rest for 1.5 s, {} substeps: centre of mass {:+.3f} %, kinetic energy {:.1e}", substeps,
                        100 * (height / 0.25 - 1), totals.kinetic / potential));
        CHECK(std::fabs(height / 0.25 - 1) < 0.003);
        CHECK(totals.kinetic < 4e-4 * potential);
    }
}

TEST_CASE("smoothing gives no energy to a pool at rest whose particles lie anyhow") {
    for (int substeps : {1, 10}) {
        CAPTURE(substeps);
        Scene scene = fluid(1.0 / 16, substeps, 1, 1e4);
        scene.max = {1, 0.75, 0};
        scene.bodies = {block(1, 0.42)};
        scene.bodies[0].seeding = Seeding::jittered;
        scene.bodies[0].jitter = 0.3;
        scene.materials[0].pressure_smoothing = 0.47;
        scene.end = 4;
        Run<> run(scene);
        const double before = totals_of(run.sim).strain;
        while (run.time() < scene.end) run.steps(1);
        const double after = totals_of(run.sim).strain;
        say(fmt::format("pool of jittered particles, {} substeps: stored energy {:.2f} times in 4 s", substeps,
                        after / before));
        CHECK(after < 2 * before);  // 8 and 3 times with means over nodes
    }
}

TEST_CASE("a drop in flight keeps its momentum, and substeps change nothing in it but noise") {
    for (int substeps : {1, 10}) {
        CAPTURE(substeps);
        Scene scene = fluid(0.125, substeps, 50, 500);
        scene.gravity = {0, 0, 0};
        scene.max = {8, 4, 0};
        BodySpec drop;
        drop.shape = BodyShape::sphere;
        drop.center = {1.5, 2, 0};
        drop.radius = 0.5;
        drop.velocity = {3, 0.5, 0};
        scene.bodies = {drop};
        scene.end = 1;
        Run<> run(scene);
        while (run.time() < scene.end) run.steps(1);
        const Totals<2> totals = totals_of(run.sim);
        CHECK(totals.momentum[0] / (3 * totals.mass) == doctest::Approx(1).epsilon(1e-12));
        CHECK(totals.momentum[1] / (0.5 * totals.mass) == doctest::Approx(1).epsilon(1e-12));
        CHECK(totals.kinetic / (0.5 * totals.mass * 9.25) == doctest::Approx(1).epsilon(1e-6));
    }
}

TEST_CASE("a runout goes as far with substeps as without, in a fifth of the steps") {
    std::vector<double> front, steps, over_filling;
    const Comm comm(MPI_COMM_WORLD);
    for (int substeps : {1, 10}) {
        Scene scene = fluid(0.25, substeps, 50, 500);
        scene.max = {80, 7.5, 0};
        scene.walls[1][0].kind = WallKind::no_slip;
        scene.walls[0][1].kind = WallKind::open;
        scene.bodies = {block(10, 5)};
        scene.end = 4;
        Run<> run(scene);
        while (run.time() < scene.end) run.steps(1);
        front.push_back(front_of(run));
        steps.push_back(double(run.sim.clock().step));
        over_filling.push_back(observe(run.sim, comm).over_filling);
        say(fmt::format("slurry at 4 s, {} substeps: front {:.2f} m, {} steps, over-filling {:.2f} %", substeps,
                        front.back(), steps.back(), 100 * over_filling.back()));
    }
    CHECK(std::fabs(front[1] / front[0] - 1) < 0.01);
    CHECK(steps[1] < steps[0] / 4.5);
    for (double share : over_filling) CHECK(share < 0.01);  // 4 % without shifts
}

TEST_CASE("a layer slides on a plane with friction as far in substeps as without, and does not sink") {
    const double slope = 24 * 3.14159265358979 / 180;
    for (double height : {0.25, 1.0}) {
        CAPTURE(height);
        std::vector<double> acceleration;
        for (int substeps : {1, 10}) {
            Scene scene = fluid(0.25, substeps, 100, 5000);
            scene.gravity = {9.81 * std::sin(slope), -9.81 * std::cos(slope)};
            scene.max = {40, 4, 0};
            scene.walls[1][0].kind = WallKind::none;
            scene.bodies = {block(15, 1.1 + height)};
            scene.bodies[0].min = {5, 1.1, 0};
            StructureSpec plane;
            plane.name = "plane", plane.law = InterfaceLaw::coulomb, plane.friction = 0.2;
            plane.point = {0, 1.1, 0}, plane.normal = {0, 1, 0};
            scene.structures = {plane};
            scene.end = 1.5;
            Run<> run(scene);
            while (run.time() < scene.end) run.steps(1);
            const Totals<2> totals = totals_of(run.sim);
            acceleration.push_back(totals.momentum[0] / totals.mass / run.time());
            double deepest = 0;
            each_particle(run.sim, [&](std::uint32_t, const auto& x) { deepest = std::max(deepest, 1.1 - x[1]); });
            const double block_has = 9.81 * (std::sin(slope) - plane.friction * std::cos(slope));
            say(fmt::format("layer of {} m, {} substeps: acceleration {:+.2f} % of the block's, deepest {:.3f} h",
                            height, substeps, 100 * (acceleration.back() / block_has - 1), deepest / scene.cell));
            CHECK(std::fabs(acceleration.back() / block_has - 1) < 0.05);  // a thick one bounces first
            CHECK(deepest < 0.15 * scene.cell);
        }
        CHECK(std::fabs(acceleration[1] / acceleration[0] - 1) < 0.01);
    }
}

TEST_CASE("a film of a cell, a row of particles and one particle alone stand on a wall") {
    for (double height : {0.5, 1.0, 2.0}) {
        CAPTURE(height);
        Scene scene = fluid(0.125, 10, 1, 0);
        scene.max = {4, 2, 0};
        scene.bodies = {block(2, 0.125 * height), block(0.0625, 0.0625)};
        scene.bodies[0].geostatic = scene.bodies[1].geostatic = false;
        scene.bodies[1].min = {3.0, 1.0, 0};
        scene.bodies[1].max = {3.0625, 1.0625, 0};
        scene.bodies[0].velocity = {0.5, -1, 0};
        scene.end = 2;
        const Comm comm(MPI_COMM_WORLD);
        Simulation<double, 2> sim(scene, comm);
        sim.seed();
        const Totals<2> before = totals_of(sim);
        double most = 0;
        while (sim.clock().time < scene.end) {
            sim.step();
            sim.conclude();
            const Totals<2> now = totals_of(sim);
            most = std::max(most, now.kinetic + 9.81 * now.centre[1]);
        }
        CHECK(most <= 1.01 * (before.kinetic + 9.81 * before.centre[1]));
    }
}
