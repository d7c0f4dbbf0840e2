#include "ends_scene.hpp"
#include "gpu/restart_pair.hpp"
#include "staged_scene.hpp"

using namespace moraine;
using namespace moraine::test;

// Absorbing ends on the device: the host's answer but for rounding.

TEST_CASE("ends absorb as on the host") {
    for (int dimensions : {2, 3})
        for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
            CAPTURE(dimensions);
            Scene scene = ground_on_ends(dimensions);
            scene.transfer = transfer;
            compare(scene, dimensions == 2 ? 60 : 40, 1e-8);
        }
    for (Shape shape : {Shape::linear, Shape::cubic}) {
        Scene scene = ground_on_ends(2);
        scene.shape = shape;
        if (shape == Shape::linear) scene.bodies.pop_back();  // whose rounding grows where the stone changes cells
        compare(scene, 60, 1e-8);
    }
    Scene rounds = ground_on_ends(2), single = ground_on_ends(3);
    rounds.stress_update = StressUpdate::musl;
    compare(rounds, 60, 1e-8);
    single.precision = Precision::single_;
    compare(single, 40, 1e-4);
}

TEST_CASE("ends matter to the device") {
    Scene scene = ground_on_ends(2);
    const Outcome absorbed = run<double, 2>(scene, 60, true);
    for (auto& axis : scene.walls)
        for (WallSpec& wall : axis)
            if (wall.absorbs) wall.kind = WallKind::free_slip, wall.absorbs = false;
    CHECK(difference(absorbed.values.front(), run<double, 2>(scene, 60, true).values.front()) > 1e-5);
}

TEST_CASE("a restart knows what ends were measured to bear") {
    compare_restart<2>(ground_on_ends(2), 33, 27);
}

TEST_CASE("ends begin with a stage as on the host") {
    Scene scene = ground_on_ends(2);
    const WallSpecs absorbing = scene.walls;
    for (auto& axis : scene.walls)
        for (WallSpec& wall : axis)
            if (wall.absorbs) wall.kind = WallKind::free_slip, wall.absorbs = false;
    scene = in_stages(scene, box({1.4, 1, 0}, {1.6, 1.2, 0}, 0));
    scene.course.stages[2].walls = absorbing, scene.course.stages[2].removes.clear();
    const Comm comm(MPI_COMM_WORLD);
    const auto run = [&](bool on_device) {
        Simulation<double, 2> sim(
            scene, comm,
            on_device ? device_engine_maker<double, 2>(scene, comm, choose_device("cuda", comm)) : nullptr);
        sim.seed();
        run_stages(sim, 25);
        return values_of(sim);
    };
    const std::vector<Values> host = run(false), device = run(true);
    for (std::size_t k = 0; k < host.size(); ++k) {
        CAPTURE(host[k].name);
        CHECK(difference(host[k], device[k]) <= 1e-8);
    }
}
