#include <doctest/doctest.h>

#include "simulation/diagnostics.hpp"
#include "terrain_scene.hpp"

using namespace moraine;

// Releases with a start and inflows: who comes in, when, and that the answer is the same on any ranks, to the bit.

namespace {

/// A valley into which a layer is released later and soil comes in over a line; `first`: something is there at once.
Scene filling_valley(bool first) {
    Scene s = test::small_valley(InterfaceLaw::voellmy, true);
    s.end = 1;
    if (!first) s.bodies.clear();
    BodySpec late;
    late.name = "late", late.shape = BodyShape::layer, late.material = 0;
    late.ground = s.structures[0].ground;
    late.points = {{1.9, 0.2}, {2.6, 0.2}, {2.6, 1}, {1.9, 1}};
    late.thickness = 0.2;
    late.release_time = 0.031;
    BodySpec torrent;
    torrent.name = "torrent", torrent.shape = BodyShape::inflow, torrent.material = 1;
    torrent.ground = s.structures[0].ground;
    torrent.points = {{0.25, 0.95}, {0.25, 0.25}};
    Hydrograph h;
    h.time = {0.005, 0.02, 0.06}, h.discharge = {0, 0.6, 0.3}, h.speed = {2, 3, 3};
    torrent.hydrograph = std::make_shared<Hydrograph>(h);
    torrent.thickness = 0.3;
    s.bodies.push_back(late), s.bodies.push_back(torrent);
    return s;
}

struct Result {
    std::uint64_t lists, state;
    std::int64_t particles;
    double time, mass, energy, momentum;
    bool operator==(const Result&) const = default;
};

/// Runs until t; asks on the way.
template <class Real, class F>
Result run(const Scene& scene, const Comm& comm, double until, bool async, const F& look) {
    Simulation<Real, 3> sim(scene, comm);
    sim.make_epochs_async(async);
    sim.seed();
    while (sim.clock().time < until) {
        sim.step(), sim.balance();
        look(sim);
    }
    sim.conclude();
    const RunClock<3>& c = sim.clock();
    return {state_hash(sim, true), state_hash(sim),    comm.sum(sim.engine().census().particles), c.time, c.start_mass,
            c.start_energy,        c.start_momentum[0]};
}

template <class Real>
void same_on_all_ranks(Scene scene) {
    const Comm all(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    const auto pass = [](const auto&) {};
    scene.balance.trigger = Trigger::never;
    const Result alone = run<Real>(scene, self, 0.09, false, pass);
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 4;
    for (const char* partitioner : {"morton", "shuffle", "slabs"})
        for (bool async : {false, true}) {
            CAPTURE(partitioner);
            CAPTURE(async);
            scene.balance.partitioner = partitioner;
            CHECK(run<Real>(scene, all, 0.09, async, pass) == alone);
        }
}

double mass_of(const Scene& scene, std::size_t body) {
    return scene.materials[static_cast<std::size_t>(scene.bodies[body].material)].density *
           (scene.bodies[body].hydrograph ? Inflow(scene, scene.bodies[body]).volume()
                                          : measure_of(scene.bodies[body], 3));
}

}  // namespace

TEST_CASE("what comes in later is the same on any number of ranks, also where nothing is there first") {
    for (bool first : {true, false}) {
        CAPTURE(first);
        same_on_all_ranks<double>(filling_valley(first));
        same_on_all_ranks<float>(filling_valley(first));
    }
}

TEST_CASE("a release comes in at its start and an inflow by its hydrograph, and no mass is lost") {
    const Comm comm(MPI_COMM_WORLD);
    Scene scene = filling_valley(false);
    const double late = mass_of(scene, 0), torrent = mass_of(scene, 1);
    scene.balance.trigger = Trigger::never;
    double before = 0, at_start = -1;
    run<double>(scene, comm, 0.09, false, [&](Simulation<double, 3>& sim) {
        const double mass = totals_of(sim).mass, time = sim.clock().time;
        CHECK(sim.clock().start_mass == doctest::Approx(mass).epsilon(1e-9));
        if (time < 0.005) CHECK(mass == 0);
        if (at_start < 0 && time >= 0.031) at_start = mass - before;
        before = mass;
    });
    CHECK(at_start >= late * (1 - 1e-9));
    CHECK(at_start < 1.2 * late);
    CHECK(before == doctest::Approx(late + torrent).epsilon(1e-9));
}

TEST_CASE("what comes in is in the balance of momentum") {
    const Comm comm(MPI_COMM_WORLD);
    Scene scene = filling_valley(true);
    scene.balance.trigger = Trigger::never;
    double worst = 0;
    run<double>(scene, comm, 0.09, false, [&](Simulation<double, 3>& sim) {
        sim.conclude();
        const Totals<3> now = totals_of(sim);
        const RunClock<3>& c = sim.clock();
        for (std::size_t a = 0; a < 3; ++a) {
            double given = sum_of(sim, sim.budget().impulse[a]);
            for (const StructureState<3>& s : sim.structures().states()) given -= sum_of(sim, s.felt.sum[a]);
            worst = std::max(
                worst, std::fabs(now.momentum[a] - c.start_momentum[a] - now.mass * c.gravity_impulse[a] - given) /
                           (now.mass * c.signal));
        }
    });
    CHECK(worst <= 1e-12);
}
