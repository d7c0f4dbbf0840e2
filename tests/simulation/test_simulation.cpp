#include <doctest/doctest.h>

#include "sample_scenes.hpp"
#include "simulation/diagnostics.hpp"

using namespace moraine;

// The answer does not depend on ranks, partitioners or repartitions, to the bit: every rank also runs the
// scene alone, and the hashes, which include each particle's place in its list, must be equal.

namespace {

using test::column;
using test::material;
using test::slurry;

struct Result {
    std::uint64_t lists, state;
    double time, dt;
    std::int64_t lost, repartitions;
    bool operator==(const Result&) const = default;
};

/// What is left of the momentum balance, as a part of mass times reference speed.
template <class Real, int Dim>
double unexplained_momentum(Simulation<Real, Dim>& sim) {
    const Totals<Dim> now = totals_of(sim);
    const RunClock<Dim>& clock = sim.clock();
    double worst = 0;
    for (std::size_t a = 0; a < Dim; ++a) {
        const double gained = now.momentum[a] + sum_of(sim, sim.budget().lost_momentum[a]) - clock.start_momentum[a];
        const double pulled = now.mass * clock.gravity_impulse[a] + sum_of(sim, sim.budget().lost_gravity_impulse[a]);
        double given = sum_of(sim, sim.budget().impulse[a]);
        for (const StructureState<Dim>& structure : sim.structures().states())
            given -= sum_of(sim, structure.felt.sum[a]);
        const double left = std::fabs(gained - pulled - given);
        if (!(left <= worst)) worst = std::isnan(left) ? HUGE_VAL : left;
    }
    return worst / (clock.start_mass * clock.signal);
}

template <class Real, int Dim>
Result run(const Scene& scene, const Comm& comm, int steps) {
    Simulation<Real, Dim> sim(scene, comm);
    sim.seed();
    const double mass = totals_of(sim).mass;
    for (int n = 0; n < steps; ++n) {
        sim.step();
        sim.balance();
    }
    sim.conclude();
    CHECK(totals_of(sim).mass + sum_of(sim, sim.budget().lost_mass) == doctest::Approx(mass).epsilon(1e-14));
    CHECK(unexplained_momentum(sim) <= (sizeof(Real) == 8 ? 1e-12 : 2e-6));
    return {
        state_hash(sim, true),    state_hash(sim), sim.clock().time, sim.clock().dt, comm.sum(sim.budget().lost_count),
        sim.counts().repartitions};
}

template <class Real, int Dim>
Result same_on_all_ranks(Scene scene, int steps) {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    scene.balance.trigger = Trigger::never;
    const Result alone = run<Real, Dim>(scene, self, steps);
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 5;
    Result all;
    for (const char* partitioner : {"morton", "shuffle", "slabs"}) {
        CAPTURE(partitioner);
        scene.balance.partitioner = partitioner;
        all = run<Real, Dim>(scene, comm, steps);
        if (partitioner != std::string("slabs")) CHECK(all.repartitions == steps / 5);
        all.repartitions = alone.repartitions;
        CHECK(all == alone);
    }
    return alone;
}

/// Two bodies that drift apart, into blocks that were empty.
Scene drifting() {
    Scene scene = slurry();
    scene.max[0] = 12;
    scene.walls[1][0].kind = WallKind::free_slip;
    scene.bodies.push_back(scene.bodies.front());
    scene.bodies[0].velocity = {10, 0, 0};
    scene.bodies[1].min = {0.2, 0, 0};
    scene.bodies[1].max = {1.2, 1, 0};
    return scene;
}

/// The hash of lists after some steps, and the epochs and repartitions that were made on the way.
struct Epochs {
    std::uint64_t hash;
    std::int64_t renewed, repartitions, migrated;
};
Epochs run_epochs(const Scene& scene, const Comm& comm, int steps, bool async) {
    Simulation<double, 2> sim(scene, comm);
    sim.make_epochs_async(async);
    sim.seed();
    for (int n = 0; n < steps; ++n) {
        sim.step();
        sim.balance();
    }
    sim.conclude();
    const RunCounts& counts = sim.counts();
    return {state_hash(sim, true), counts.epochs, counts.repartitions, comm.sum(counts.migrated_particles)};
}

/// Of each imbalance check that planned, the steps from its begin to its end; one every 40 steps where nothing is in
/// its way.
std::vector<std::int64_t> checks_of(Scene scene, int steps) {
    const Comm comm(MPI_COMM_WORLD);
    scene.balance.trigger = Trigger::threshold;
    scene.balance.threshold = 1;
    scene.balance.interval = 40;
    Simulation<double, 2> sim(scene, comm);
    sim.make_epochs_async(true);
    sim.seed();
    std::vector<std::int64_t> lasted;
    for (int n = 0; n < steps; ++n) {
        sim.step();
        sim.balance();
        const ImbalanceCheck check = sim.take_imbalance_check();
        if (check.terms.step > 0) lasted.push_back(sim.clock().step - check.terms.step);
    }
    sim.conclude();
    return lasted;
}

const moraine::Shape every_shape[] = {moraine::Shape::linear, moraine::Shape::gimp, moraine::Shape::gimp_contiguous,
                                      moraine::Shape::quadratic, moraine::Shape::cubic};

}  // namespace

TEST_CASE("thin layers on structures that rest, move and are free are the same on any number of ranks") {
    for (moraine::Shape shape : every_shape)
        for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
            if (shape == moraine::Shape::linear && transfer == Transfer::apic) continue;
            CAPTURE(int(shape));
            Scene scene = test::layers_on_slope(2);
            scene.shape = shape, scene.transfer = transfer;
            scene.cfl = 0.2;
            if (transfer == Transfer::apic) scene.stress_update = StressUpdate::musl;
            same_on_all_ranks<double, 2>(scene, 100);
        }
    same_on_all_ranks<float, 2>(test::layers_on_slope(2), 60);
    same_on_all_ranks<double, 3>(test::layers_on_slope(3), 40);
}

TEST_CASE("a slurry that leaves through an open wall is the same on any number of ranks, for every shape") {
    for (moraine::Shape shape : every_shape) {
        CAPTURE(int(shape));
        Scene scene = slurry();
        scene.shape = shape;
        const Result r = same_on_all_ranks<double, 2>(scene, 40);
        CHECK(r.lost > 0);
    }
}

TEST_CASE("it is the same whether epochs are made when they are needed or before that, asynchronously") {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    Scene scene = drifting();
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 61;
    const Epochs alone = run_epochs(scene, self, 250, false);
    CHECK(alone.renewed >= 3);
    for (const char* partitioner : {"morton", "shuffle", "slabs"}) {
        CAPTURE(partitioner);
        scene.balance.partitioner = partitioner;
        for (bool async : {true, false}) {
            CAPTURE(async);
            const Epochs all = run_epochs(scene, comm, 250, async);
            CHECK(all.hash == alone.hash);
            CHECK(all.renewed >= 3);
        }
    }
}

TEST_CASE("it is the same whether imbalance checks are made at once or begin steps before they are due") {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    Scene scene = drifting();
    const int steps = 139;  // one that begins at 137 is still under way at the end
    scene.balance.trigger = Trigger::every;
    const Epochs alone = run_epochs(scene, self, steps, false);
    for (const char* partitioner : {"morton", "shuffle"})
        for (const int interval : {1, 7, 40})  // 0, 3 and 16 steps before
            for (bool async : {true, false}) {
                CAPTURE(partitioner);
                CAPTURE(interval);
                CAPTURE(async);
                scene.balance.partitioner = partitioner;
                scene.balance.interval = interval;
                const Epochs all = run_epochs(scene, comm, steps, async);
                CHECK(all.hash == alone.hash);
                CHECK(all.repartitions == steps / interval);
                if (comm.size() > 1 && partitioner == std::string("shuffle")) CHECK(all.migrated > 0);
            }
}

TEST_CASE("no imbalance check is cut short by the end of an epoch: it begins after the next epoch") {
    Scene scene = drifting();
    scene.bodies[0].velocity = {2, 0, 0};
    scene.cfl = 0.15;  // less than a cell in an imbalance check
    const std::vector<std::int64_t> lasted = checks_of(scene, 600);
    for (const std::int64_t steps : lasted) CHECK(steps >= Rebalance<2>::most_steps_ahead);
    if (Comm(MPI_COMM_WORLD).size() > 1)
        CHECK(lasted.size() >= 5);
    else
        CHECK(lasted.empty());
}

TEST_CASE("there are imbalance checks where epochs are shorter than an imbalance check, too") {
    if (Comm(MPI_COMM_WORLD).size() > 1) CHECK(checks_of(drifting(), 400).size() >= 4);
}

TEST_CASE("it is the same where shares are balanced by measured time") {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    Scene scene = drifting();
    scene.balance.trigger = Trigger::never;
    const Epochs alone = run_epochs(scene, self, 134, false);
    scene.balance.weight = "time";
    scene.balance.interval = 10;
    scene.balance.threshold = 1;
    for (Trigger trigger : {Trigger::every, Trigger::threshold, Trigger::planned})
        for (bool async : {true, false}) {
            CAPTURE(async);
            scene.balance.trigger = trigger;
            const Epochs all = run_epochs(scene, comm, 134, async);
            CHECK(all.hash == alone.hash);
            if (trigger == Trigger::every) CHECK(all.repartitions == 13);
            if (trigger == Trigger::threshold && comm.size() > 1) CHECK(all.repartitions > 0);
        }
}

TEST_CASE("it is the same for every transfer and stress update, and balances its momentum") {
    for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::tpic, Transfer::aflip})
        for (StressUpdate update : {StressUpdate::usl, StressUpdate::usf, StressUpdate::musl}) {
            CAPTURE(int(transfer));
            CAPTURE(int(update));
            Scene scene = slurry();
            scene.transfer = transfer;
            scene.stress_update = update;
            same_on_all_ranks<double, 2>(scene, 30);
        }
}

TEST_CASE("it is the same in single precision and with a mix of FLIP and PIC") {
    Scene scene = slurry();
    scene.flip = 0.95;
    same_on_all_ranks<float, 2>(scene, 40);
    scene.shape = moraine::Shape::gimp;
    scene.transfer = Transfer::apic;
    same_on_all_ranks<float, 2>(scene, 40);
}

TEST_CASE("it is the same for the series of FMPM, and balances its momentum") {
    for (int order : {1, 2, 3}) {
        CAPTURE(order);
        Scene flat = slurry(), deep = column();
        flat.transfer = deep.transfer = Transfer::fmpm;
        flat.order = deep.order = order;
        flat.cfl = deep.cfl = 0.3;
        same_on_all_ranks<double, 2>(flat, 30);
        same_on_all_ranks<float, 3>(deep, 10);
    }
}

TEST_CASE("a step of k terms of FMPM is 1 / sqrt(k) of that of one") {
    Scene scene = slurry();
    scene.transfer = Transfer::fmpm;
    const Comm self(MPI_COMM_SELF);
    const auto first_step = [&](int order) {
        scene.order = order;
        Simulation<double, 2> sim(scene, self);
        sim.seed();
        sim.step();
        return sim.clock().dt;
    };
    CHECK(first_step(4) == doctest::Approx(first_step(1) / 2));
}

TEST_CASE("it is the same where cells have one pressure") {
    Scene scene = slurry();
    scene.materials[0].volumetric = Volumetric::cell;
    const Result r = same_on_all_ranks<double, 2>(scene, 40);
    scene.materials[0].volumetric = Volumetric::particle;
    CHECK(!(same_on_all_ranks<double, 2>(scene, 40) == r));
}

TEST_CASE("it is the same where pressures are smoothed and particles shifted, and balances its momentum") {
    Scene scene = slurry();
    scene.bodies[0].particles_per_cell = {3, 3, 3};
    scene.bodies[0].jitter = 0.5;  // crowded here and there
    using enum StressUpdate;
    for (auto [transfer, update] : {std::pair{Transfer::flip, usl}, {Transfer::apic, musl}, {Transfer::aflip, usl}}) {
        CAPTURE(int(transfer));
        scene.transfer = transfer;
        scene.stress_update = update;
        MaterialSpec& mud = scene.materials[0];
        mud.pressure_smoothing = mud.particle_shifting = 0;
        const Result plain = run<double, 2>(scene, Comm(MPI_COMM_SELF), 20);
        mud.pressure_smoothing = 0.22;
        const Result smooth = same_on_all_ranks<double, 2>(scene, 20);
        CHECK(smooth.state != plain.state);
        mud.particle_shifting = 0.1;
        CHECK(same_on_all_ranks<double, 2>(scene, 20).state != smooth.state);
    }
}

TEST_CASE("shifts are the same in 3-D, across a periodic axis, in single precision and beside a structure") {
    Scene scene = column();
    scene.materials = {material("newtonian", 1500, {{"young", 1e6}, {"poisson", 0.45}, {"viscosity", 100}}),
                       material("linear-elastic", 1500, {{"young", 2e6}, {"poisson", 0.3}})};
    scene.materials[0].pressure_smoothing = 0.22;
    scene.materials[0].particle_shifting = 0.1;
    scene.bodies[0].jitter = 0.5;
    const Result one = same_on_all_ranks<float, 3>(scene, 15);
    StructureSpec ball;
    ball.name = "ball";
    ball.shape = StructureShape::sphere;
    ball.center = {2, 4, 6.5};
    ball.radius = 1;
    scene.structures.push_back(ball);
    CHECK(same_on_all_ranks<float, 3>(scene, 15).state != one.state);
}

TEST_CASE("the grid's pressure is the same on any number of ranks, with and without substeps") {
    Scene scene = slurry();
    scene.bodies[0].jitter = 0.5;
    MaterialSpec& mud = scene.materials[0];
    mud.parameters[1] = 0.49;
    mud.volumetric = Volumetric::grid;
    std::vector<std::uint64_t> states;
    for (int substeps : {1, 10})
        for (double share : {0.0, 0.2}) {
            scene.substeps = substeps;
            mud.pressure_smoothing = mud.particle_shifting = share;
            states.push_back(same_on_all_ranks<double, 2>(scene, 20).state);
        }
    scene.transfer = Transfer::aflip;
    states.push_back(same_on_all_ranks<float, 2>(scene, 20).state);
    scene.structures.resize(2);
    scene.structures[0].name = "plane", scene.structures[0].point = {0, 0.05, 0};
    scene.structures[0].normal = {0.05, 1, 0};
    scene.structures[1].name = "ball", scene.structures[1].shape = StructureShape::sphere;
    scene.structures[1].center = {3.3, 1.1, 0}, scene.structures[1].radius = 0.2;
    scene.structures[1].motion.kind = StructureMotion::velocity, scene.structures[1].motion.velocity = {1, 0, 0};
    states.push_back(same_on_all_ranks<double, 2>(scene, 20).state);
    std::sort(states.begin(), states.end());
    CHECK(std::adjacent_find(states.begin(), states.end()) == states.end());
}

TEST_CASE("so it is in 3-D, across a periodic axis, beside a solid and a structure") {
    Scene scene = column();
    scene.materials = {material("newtonian", 1500, {{"young", 1e6}, {"poisson", 0.45}, {"viscosity", 100}}),
                       material("linear-elastic", 1500, {{"young", 2e6}, {"poisson", 0.3}})};
    scene.materials[0].volumetric = Volumetric::grid;
    scene.materials[0].pressure_smoothing = 0.22;
    scene.materials[0].particle_shifting = 0.1;
    scene.bodies[0].jitter = 0.5;
    const Result one = same_on_all_ranks<float, 3>(scene, 15);
    StructureSpec ball;
    ball.name = "ball";
    ball.shape = StructureShape::sphere;
    ball.center = {2, 4, 6.5};
    ball.radius = 1;
    scene.structures.push_back(ball);
    CHECK(same_on_all_ranks<float, 3>(scene, 15).state != one.state);
}

TEST_CASE("over-filling is the same on any number of ranks") {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    Scene scene = slurry();
    scene.balance.partitioner = "shuffle";
    scene.bodies[0].jitter = 0.5;
    const auto volumes = [&](const Comm& on) {
        Simulation<double, 2> sim(scene, on);
        sim.seed();
        for (int n = 0; n < 30; ++n) sim.step(), sim.balance();
        sim.conclude();
        const std::uint64_t before = state_hash(sim, true);
        const NodeVolumes all = on.exact_sum(sim.answer(VolumeQuery{}).volumes);
        CHECK(state_hash(sim, true) == before);
        sim.step();
        sim.conclude();
        return std::pair(all, state_hash(sim, true));
    };
    const auto [alone, after] = volumes(self);
    const auto [shared, after_shared] = volumes(comm);
    CHECK(alone.over_filling() > 1e-3);
    CHECK(shared.above.low == alone.above.low);
    CHECK(shared.all.low == alone.all.low);
    CHECK(shared.all.high == alone.all.high);
    CHECK(after_shared == after);
}

TEST_CASE("two soils in a periodic channel are the same on any number of ranks, for every shape") {
    for (moraine::Shape shape : every_shape) {
        CAPTURE(int(shape));
        Scene scene = column();
        scene.shape = shape;
        // A hat's slope is full where its weight is next to nothing: long steps turn particles inside out.
        if (shape == moraine::Shape::linear) scene.cfl = 0.2;
        same_on_all_ranks<double, 3>(scene, 15);
    }
}

TEST_CASE("a 3-D column is the same for the affine transfers and two-round schemes, in both precisions") {
    Scene scene = column();
    scene.transfer = Transfer::apic;
    scene.stress_update = StressUpdate::musl;
    same_on_all_ranks<double, 3>(scene, 15);
    scene.transfer = Transfer::tpic;
    scene.stress_update = StressUpdate::usf;
    same_on_all_ranks<float, 3>(scene, 15);
}
