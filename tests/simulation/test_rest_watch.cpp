#include <doctest/doctest.h>

#include "core/rest_interval.hpp"
#include "sample_scenes.hpp"
#include "simulation/rest_watch.hpp"

using namespace moraine;

// Bodies that drift freely, so that what each has moved in an interval is its speed times 0.1 s.

namespace {

/// 400 particles that stay where they are, and one of four cells that drifts along x.
Scene drifting(double speed) {
    Scene s;
    s.dimensions = 2;
    s.max = {8, 4, 0};
    s.cell = 0.25;
    s.end = 10;
    s.materials = {test::material("linear-elastic", 1000, {{"young", 1e5}, {"poisson", 0.3}})};
    s.bodies = {test::box({0.5, 0.5, 0}, {3, 3, 0}, 0), test::box({6.5, 1, 0}, {7, 1.5, 0}, 0)};
    s.bodies[1].velocity = {speed, 0, 0};
    s.rest = {true, 0.1, 0.99, 0.1, 3};
    return s;
}

/// Intervals that ended, and whether it was at rest then.
struct Ended {
    double time;
    std::int64_t intervals, step;
    bool operator==(const Ended&) const = default;
};

Ended run(const Scene& scene, const Comm& comm, double end, std::vector<std::int64_t>* stored = nullptr) {
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    RestWatch<2> watch(scene, comm);
    Ended ended{0, 0, 0};
    while (sim.clock().time < end && !watch.is_at_rest()) {
        ended.intervals += watch.is_due(sim.clock().time);
        watch.look(sim);
        if (watch.is_at_rest()) break;
        sim.step();
        sim.balance();
    }
    sim.conclude();
    if (stored) *stored = watch.stored();
    return {sim.clock().time, ended.intervals - 1, sim.clock().step};
}

Ended same_on_all_ranks(Scene scene, double end) {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    scene.balance.trigger = Trigger::never;
    const Ended alone = run(scene, self, end);
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 7;
    scene.balance.partitioner = "shuffle";
    CHECK(run(scene, comm, end) == alone);
    return alone;
}

}  // namespace

TEST_CASE("a run is at rest after so many intervals in which nearly all has moved less than so much") {
    CHECK(same_on_all_ranks(drifting(0), 2).intervals == 3);
    Scene scene = drifting(0.2);  // 0.08 cells in an interval
    scene.rest.intervals = 5;
    const Ended slow = same_on_all_ranks(scene, 2);
    CHECK(slow.intervals == 5);
    CHECK(slow.time == doctest::Approx(0.5).epsilon(0.05));
}

TEST_CASE("what drifts faster keeps a run awake if it is more than the rest of the mass") {
    Scene scene = drifting(0.3);  // 0.12 cells; 16 of 416 particles
    CHECK(same_on_all_ranks(scene, 0.45).time >= 0.45);
    scene.rest.mass = 0.96;
    CHECK(same_on_all_ranks(scene, 0.45).intervals == 3);
}

TEST_CASE("what goes around a periodic axis has not gone through the whole domain") {
    Scene scene = drifting(0.2);
    scene.bodies[1].min[0] = 7.5, scene.bodies[1].max[0] = 8;
    scene.periodic[0] = true;
    scene.walls[0][0].kind = scene.walls[0][1].kind = WallKind::periodic;
    CHECK(same_on_all_ranks(scene, 2).intervals == 3);
}

TEST_CASE("what has left through an open wall has moved") {
    Scene scene = drifting(2);
    scene.bodies[1].min[0] = 7.25, scene.bodies[1].max[0] = 7.75;
    scene.walls[0][1].kind = WallKind::open;
    const Ended ended = same_on_all_ranks(scene, 2);
    CHECK(ended.intervals > 4);
    CHECK(ended.time < 1);
}

TEST_CASE("what a checkpoint keeps of it is taken by the same rule only") {
    const Comm comm(MPI_COMM_WORLD);
    const Scene scene = drifting(0);
    std::vector<std::int64_t> all;
    run(scene, comm, 2, &all);
    RestWatch<2> same(scene, comm);
    CHECK(same.restore(all));
    CHECK(same.is_at_rest());
    CHECK(same.stored() == all);

    Scene stricter = scene;
    stricter.rest.displacement = 0.05;
    RestWatch<2> other(stricter, comm);
    CHECK(other.restore(all));
    CHECK(!other.is_at_rest());
    CHECK(other.is_due(0));

    std::vector<std::int64_t> cut(all.begin(), all.end() - 1), twice = all, negative = all;
    twice[11] = twice[7];  // the second id
    negative[1] = -1;
    for (const auto& wrong : {std::vector<std::int64_t>{}, cut, twice, negative}) {
        RestWatch<2> watch(scene, comm);
        CHECK(!watch.restore(wrong));
        CHECK(!watch.is_at_rest());
    }
}

TEST_CASE("an interval is by gravity and the cells where the scene does not say") {
    Scene scene = drifting(0);
    CHECK(rest_interval(scene) == 0.1);
    scene.rest.interval = 0;
    CHECK(rest_interval(scene) == 0);
    const double of_small = (scene.gravity = {3, -4, 0}, rest_interval(scene));
    scene.cell *= 4;
    CHECK(rest_interval(scene) == doctest::Approx(2 * of_small));
}
