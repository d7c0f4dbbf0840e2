#include "core/sleep/sleep.hpp"
#include "gpu/engine_pair.hpp"
#include "io/test_folder.hpp"
#include "records/checkpoint_state.hpp"
#include "sleep_scene.hpp"

using namespace moraine;
using namespace moraine::test;

// Blocks fall asleep and wake on a device as on the host: the same blocks at the same steps, and what they leave of
// every particle and of the budget is the host's but for rounding.

namespace {

/// A run, looked at every so many steps.
struct SleptRun {
    std::vector<std::int64_t> asleep;                  ///< particles
    std::vector<std::vector<std::uint64_t>> sleepers;  ///< their ids
    std::vector<double> budget;                        ///< what sleep took, at the end
    Outcome end;
};

template <class Real, int Dim>
std::vector<std::uint64_t> sleepers_of(Simulation<Real, Dim>& sim) {
    std::vector<std::uint64_t> ids;
    const ParticleView<Real, Dim> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, Dim>&) {
        if (p.rest_place[s] & rest_word::asleep) ids.push_back(p.id[s]);
    });
    std::sort(ids.begin(), ids.end());
    return ids;
}

template <class Real, int Dim>
SleptRun run_asleep(const Scene& scene, int steps, int every, bool on_device) {
    const Comm comm(MPI_COMM_WORLD);
    const DeviceChoice device = on_device ? choose_device("cuda", comm) : DeviceChoice{};
    Simulation<Real, Dim> sim(scene, comm, on_device ? device_engine_maker<Real, Dim>(scene, comm, device) : nullptr);
    sim.seed();
    SleptRun out;
    for (int k = 1; k <= steps; ++k) {
        sim.step(), sim.balance();
        if (k % every != 0) continue;
        sim.conclude();
        if (k % (4 * every) == 0) sim.answer(VolumeQuery{});  // which writes to all tiles
        out.asleep.push_back(sim.engine().census().asleep);
        out.sleepers.push_back(sleepers_of(sim));
    }
    sim.conclude();
    out.end = {values_of(sim), state_hash(sim, true), sim.clock().time, {}, {}, {}};
    const Budget<Dim>& budget = sim.budget();
    for (const ExactSum& s : {budget.slept_kinetic, budget.slept_momentum[0], budget.slept_momentum[Dim - 1]})
        out.budget.push_back(sim.quantum().value(s));
    const Totals<Dim> now = totals_of(sim);
    for (std::size_t a = 0; a < Dim; ++a) {  // the balance of momentum closes on its own
        const double gained =
            now.momentum[a] - sim.clock().start_momentum[a] + sim.quantum().value(budget.slept_momentum[a]);
        double left = gained - now.mass * sim.clock().gravity_impulse[a] - sim.quantum().value(budget.impulse[a]);
        for (std::size_t k = 0; k < sim.structures().size(); ++k)
            left += sim.quantum().value(sim.structures().state(k).felt.sum[a]);
        CHECK(std::fabs(left) <= (sizeof(Real) == 8 ? 1e-12 : 2e-6) * sim.clock().start_mass * sim.clock().signal);
    }
    return out;
}

template <class Real, int Dim>
void compare_asleep(const Scene& scene, int steps, double tolerance) {
    const SleptRun host = run_asleep<Real, Dim>(scene, steps, 16, false);
    const SleptRun device = run_asleep<Real, Dim>(scene, steps, 16, true);
    CHECK(run_asleep<Real, Dim>(scene, steps, 16, true).end.hash == device.end.hash);
    CHECK(run_asleep<Real, Dim>(scene, steps, steps, true).end.hash == device.end.hash);  // however often one looks
    CHECK(device.asleep == host.asleep);
    CHECK(device.sleepers == host.sleepers);
    CHECK(*std::max_element(host.asleep.begin(), host.asleep.end()) > 0);
    CHECK(device.end.time == doctest::Approx(host.end.time).epsilon(tolerance));
    for (std::size_t k = 0; k < host.end.values.size(); ++k) {
        CAPTURE(host.end.values[k].name);
        const double d = difference(host.end.values[k], device.end.values[k]);
        MESSAGE(scene.name << " " << host.end.values[k].name << ": " << d);
        CHECK(d <= tolerance);
    }
    for (std::size_t k = 0; k < host.budget.size(); ++k) {
        CAPTURE(k);
        CHECK(device.budget[k] ==
              doctest::Approx(host.budget[k]).epsilon(1e3 * tolerance).scale(std::fabs(host.budget[0])));
    }
}

}  // namespace

TEST_CASE("a bed falls asleep on a device as on the host, and wakes where it is struck") {
    compare_asleep<double, 2>(bed(2), 700, 1e-10);
}

TEST_CASE("so it does in 3-D, across a periodic axis") {
    compare_asleep<double, 3>(bed(3), 500, 1e-10);
}

TEST_CASE("so it does where a post stands on it, and where two materials meet") {
    Scene scene = bed(2);
    StructureSpec post;
    post.name = "post";
    post.shape = StructureShape::box;
    post.min = {3, 0.6, 0}, post.max = {3.3, 0.9, 0};
    scene.structures.push_back(post);
    compare_asleep<double, 2>(scene, 400, 1e-10);
    Scene two = bed(2);
    two.materials.push_back(material("linear-elastic", 1500, {{"young", 1e6}, {"poisson", 0.3}}));
    two.bodies[1].material = 1;
    compare_asleep<double, 2>(two, 400, 1e-10);
}

TEST_CASE("so it does where a plate goes down into it") {
    compare_asleep<double, 2>(plate_over_bed(2), 600, 1e-10);
    compare_asleep<double, 3>(plate_over_bed(3), 500, 1e-10);
}

TEST_CASE("so it does beside surfaces that act where they are") {
    Scene scene = plate_over_bed(2);
    scene.bed = Bed::surface;
    compare_asleep<double, 2>(scene, 500, 1e-8);
    scene.structures.back().motion = {};
    scene.structures.back().min[1] = 0.6;
    compare_asleep<double, 2>(scene, 300, 1e-8);
}

TEST_CASE("so it does in single precision, the same blocks at the same steps") {
    compare_asleep<float, 2>(bed(2), 400, 1e-3);
}

TEST_CASE("so does mud whose cells bear the pressure, with and without substeps") {
    for (int substeps : {1, 10}) {
        Scene scene = mud();
        scene.substeps = substeps;
        compare_asleep<double, 2>(scene, 400, 1e-9);
    }
}

TEST_CASE("a restart while some of the bed sleeps goes on with the same bits") {
    Scene scene = bed(2);
    scene.bodies[0].name = "bed", scene.bodies[1].name = "block";  // files tell them apart
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const auto maker = device_engine_maker<double, 2>(scene, comm, choose_device("cuda", comm));
    Simulation<double, 2> straight(scene, comm, maker), restarted(scene, comm, maker);
    straight.seed();
    advance(straight, 157);
    CHECK(6 * straight.engine().census().asleep > straight.engine().census().particles);
    save(straight, comm, folder / "state");
    load(restarted, comm, CheckpointReader(comm, folder / "state"), folder / "state");
    CHECK(restarted.engine().census().asleep == straight.engine().census().asleep);
    advance(straight, 60);
    advance(restarted, 60);
    CHECK(state_hash(restarted) == state_hash(straight));
}
