#include <doctest/doctest.h>

#include "core/sleep/sleep.hpp"
#include "simulation/diagnostics.hpp"
#include "sleep_scene.hpp"

using namespace moraine;
using test::bed, test::material, test::mud, test::plate_over_bed;

// Blocks that rest are left out of the step, and wake; who sleeps when is the same on any ranks, to the bit.

namespace {

struct Result {
    std::uint64_t lists;
    std::int64_t most_asleep, asleep;
    double time;
    bool operator==(const Result&) const = default;
};

template <class Real, int Dim>
double unexplained_momentum(Simulation<Real, Dim>& sim) {
    const Totals<Dim> now = totals_of(sim);
    const RunClock<Dim>& clock = sim.clock();
    double worst = 0;
    for (std::size_t a = 0; a < Dim; ++a) {
        const double gained = now.momentum[a] - clock.start_momentum[a] + sum_of(sim, sim.budget().slept_momentum[a]);
        double left = gained - now.mass * clock.gravity_impulse[a] - sum_of(sim, sim.budget().impulse[a]);
        for (std::size_t k = 0; k < sim.structures().size(); ++k)
            left += sum_of(sim, sim.structures().state(k).felt.sum[a]);
        worst = std::max(worst, std::fabs(left));
    }
    return worst / (clock.start_mass * clock.signal);
}

template <class Real, int Dim>
Result run(const Scene& scene, const Comm& comm, double end) {
    Simulation<Real, Dim> sim(scene, comm);
    sim.seed();
    std::int64_t most = 0;
    const auto asleep = [&] { return comm.sum(sim.engine().census().asleep); };
    while (sim.clock().time < end) {
        sim.step();
        sim.balance();
        most = std::max(most, asleep());
    }
    sim.conclude();
    CHECK(unexplained_momentum(sim) <= (sizeof(Real) == 8 ? 1e-12 : 2e-6));
    return {state_hash(sim, true), most, asleep(), sim.clock().time};
}

template <class Real, int Dim>
Result same_on_all_ranks(Scene scene, double end) {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    scene.balance.trigger = Trigger::never;
    const Result alone = run<Real, Dim>(scene, self, end);
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 17;
    for (const char* partitioner : {"morton", "shuffle", "slabs"}) {
        CAPTURE(partitioner);
        scene.balance.partitioner = partitioner;
        CHECK(run<Real, Dim>(scene, comm, end) == alone);
    }
    return alone;
}

}  // namespace

TEST_CASE("a bed falls asleep, and wakes where it is struck, the same on any number of ranks") {
    const Result asleep = same_on_all_ranks<double, 2>(bed(2), 0.22);
    CHECK(asleep.asleep > 400);
    const Result struck = same_on_all_ranks<double, 2>(bed(2), 0.5);
    CHECK(struck.most_asleep > struck.asleep + 100);
}

TEST_CASE("so it does in 3-D, across a periodic axis and in single precision") {
    const Result struck = same_on_all_ranks<float, 3>(bed(3), 0.4);
    CHECK(struck.most_asleep > struck.asleep + 100);
}

TEST_CASE("so does mud whose cells bear the pressure, with and without substeps") {
    Scene scene = mud();
    for (int substeps : {1, 10}) {
        scene.substeps = substeps;
        const Result struck = same_on_all_ranks<double, 2>(scene, 0.36);
        CHECK(struck.most_asleep > struck.asleep + 100);
        CHECK(struck.asleep > 100);
    }
}

TEST_CASE("a structure that begins to move wakes the bed under it, the same on any number of ranks") {
    for (const Result& moved :
         {same_on_all_ranks<double, 2>(plate_over_bed(2), 0.4), same_on_all_ranks<float, 3>(plate_over_bed(3), 0.35)}) {
        CHECK(moved.asleep > 100);
        CHECK(moved.most_asleep > moved.asleep + 50);
    }
}

TEST_CASE("near a structure that stands blocks sleep, and near one that moves none does in any step") {
    const Scene scene = plate_over_bed(2);
    const StructureSet<2> at_start(scene);
    const ContactField<2> field = at_start.field();
    const Comm self(MPI_COMM_SELF);
    Simulation<double, 2> sim(scene, self);
    sim.seed();
    std::int64_t most_while_it_stood = 0, while_it_moved = 0;
    while (sim.clock().time < 0.4) {
        sim.step();
        sim.conclude();
        const Vec<double, 2> gone = sim.structures().state(0).displacement;
        std::int64_t near = 0;
        each_particle(sim, [&](std::uint32_t s, const std::array<double, 2>& x) {
            const double d =
                surface_of_body(field.structure[0], field.corners, {{x[0] - gone[0], x[1] - gone[1]}}).distance;
            near += d < 1.5 * scene.cell && (sim.patch().particles.view().rest_place[s] & rest_word::asleep) != 0;
        });
        if (gone[1] == 0)
            most_while_it_stood = std::max(most_while_it_stood, near);
        else
            while_it_moved += near;
    }
    CHECK(most_while_it_stood > 10);
    CHECK(while_it_moved == 0);
}

TEST_CASE("what falls from rest is not taken for what rests, however small its steps are") {
    Scene scene = bed(2);
    scene.bodies.erase(scene.bodies.begin());
    scene.dt = 1e-4;  // 1000 a sleep check
    CHECK(run<double, 2>(scene, Comm(MPI_COMM_SELF), 0.3).most_asleep == 0);
}

TEST_CASE("a displacement between two places of blocks is that modulo a block") {
    const auto place = [](double x, double y) {
        const double cell = static_cast<double>(one_cell<double>);
        return rest_place<double, 2>({static_cast<std::uint64_t>(x * cell), static_cast<std::uint64_t>(y * cell)});
    };
    CHECK(displacement_between<2>(place(1.25, 2), place(1.5, 2)) == doctest::Approx(0.25));
    CHECK(displacement_between<2>(place(0.01, 1), place(3.98, 1)) == doctest::Approx(0.03).epsilon(1e-4));
    CHECK(displacement_between<2>(place(1, 3), place(1, 1.1)) == doctest::Approx(1.9));
    CHECK(displacement_between<2>(place(1, 3) | rest_word::asleep, place(1, 3)) == 0);
}

TEST_CASE("where ranks cannot hold what would even out the load, each holds what it can, and the answer is the same") {
    Scene scene = bed(2);
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    const Result alone = run<double, 2>(scene, self, 0.4);
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 17;
    const std::int64_t mean = (1236 + comm.size() - 1) / comm.size();
    std::int64_t fullest = 0;  // of any rank after any repartition, with as much memory as anyone wants
    for (const std::int64_t most : {unlimited_particles, mean + 64}) {
        CAPTURE(most);
        Simulation<double, 2> sim(scene, comm);
        sim.hold_at_most(most);
        sim.seed();
        std::int64_t now = 0, made = 0;
        while (sim.clock().time < 0.4) {
            sim.step();
            sim.balance();
            if (sim.counts().repartitions > made) now = std::max(now, comm.max(sim.engine().census().particles));
            made = sim.counts().repartitions;
        }
        sim.conclude();
        CHECK(state_hash(sim, true) == alone.lists);
        if (most == unlimited_particles) fullest = now;
        if (comm.size() == 1) continue;
        CHECK(made > 5);
        CHECK(now <= most);
        CHECK(fullest > mean + 64);
    }
}
