#include "gpu/restart_pair.hpp"
#include "surface_scenes.hpp"
#include "turning_scene.hpp"

using namespace moraine;
using namespace moraine::test;

// Structures that turn: the host's answer but for rounding.

namespace {

/// How they moved and turned, what they felt, and how that would change with their motion in the last step.
template <int Dim>
std::array<std::vector<double>, 3> motions(const Scene& scene, int steps, bool on_device) {
    const Comm comm(MPI_COMM_WORLD);
    const DeviceChoice device = on_device ? choose_device("cuda", comm) : DeviceChoice{};
    Simulation<double, Dim> sim(scene, comm,
                                on_device ? device_engine_maker<double, Dim>(scene, comm, device) : nullptr);
    sim.seed();
    advance(sim, steps);
    std::array<std::vector<double>, 3> all;
    for (std::size_t k = 1; k < scene.structures.size(); ++k) {
        const StructureState<Dim>& state = sim.structures().state(k);
        for (int a = 0; a < Dim; ++a) all[0].push_back(state.displacement[a]), all[0].push_back(state.velocity[a]);
        for (double e : state.turned.e) all[0].push_back(e);
        for (int a = 0; a < moments<Dim>; ++a) all[0].push_back(state.spin[a]);
        for (const ExactSum& sum : state.felt.sum) all[1].push_back(sim.quantum().value(sum));
        for (const ExactSum& sum : state.pending_turning.sum) all[2].push_back(sim.quantum().value(sum));
    }
    return all;
}

/// Each group over its largest: some of a sum's components are zero but for rounding.
template <int Dim>
void compare_motions(const Scene& scene, int steps) {
    const auto host = motions<Dim>(scene, steps, false), device = motions<Dim>(scene, steps, true);
    CHECK(device == motions<Dim>(scene, steps, true));
    constexpr double tolerance[] = {1e-8, 1e-6, 1e-6};
    for (std::size_t g = 0; g < 3; ++g) {
        CAPTURE(g);
        double scale = 0, worst = 0;
        for (std::size_t k = 0; k < host[g].size(); ++k) {
            scale = std::max(scale, std::fabs(host[g][k]));
            worst = std::max(worst, std::fabs(device[g][k] - host[g][k]));
        }
        MESSAGE(scene.dimensions << "-D, group " << g << ": " << worst << " of " << scale);
        CHECK(scale > 0);
        CHECK(worst <= tolerance[g] * scale);
    }
}

/// What nothing strains and no structure feels is rounding alone, which two sides do not share.
void compare_felt(const Scene& scene, int steps, double tolerance) {
    const Outcome host = compare(scene, steps, tolerance);
    for (const Values& column : host.values)
        if (column.name == "ln_J") CHECK(column.scale > 1e-3);
    for (double felt : host.felt) CHECK(felt > 1e-3);
}

/// Of one fluid, whose pressures are the grid's.
Scene wet_turning(int dimensions) {
    Scene scene = on_surface(turning_on_slope(dimensions));
    scene.materials.pop_back();
    for (BodySpec& body : scene.bodies) body.material = 0;
    return wet(scene, 1);
}

}  // namespace

TEST_CASE("structures that turn give the host's answer, at nodes and on surfaces") {
    for (int dimensions : {2, 3})
        for (Bed bed : {Bed::nodes, Bed::surface})
            for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
                CAPTURE(dimensions);
                CAPTURE(int(bed));
                CAPTURE(int(transfer));
                Scene scene = turning_on_slope(dimensions);
                scene.bed = bed, scene.transfer = transfer;
                compare_felt(scene, dimensions == 2 ? 80 : 40, 1e-8);
            }
}

TEST_CASE("a fluid whose pressures are the grid's feels them turn as on the host") {
    compare_felt(wet_turning(2), 60, 1e-8);
    compare_felt(wet_turning(3), 30, 1e-8);
    compare_motions<2>(wet_turning(2), 60);
}

TEST_CASE("they move, turn and feel as on the host") {
    for (Bed bed : {Bed::nodes, Bed::surface}) {
        CAPTURE(int(bed));
        Scene flat = turning_on_slope(2), deep = turning_on_slope(3);
        flat.bed = deep.bed = bed;
        compare_motions<2>(flat, 80);
        compare_motions<3>(deep, 40);
    }
}

TEST_CASE("that they turn matters to the device") {
    Scene scene = turning_on_slope(2);
    const Outcome turning = run<double, 2>(scene, 80, true);
    scene.structures[1].motion.turns = false;
    for (StructureSpec& s : scene.structures) s.motion.angular_velocity.clear();
    CHECK(difference(turning.values.front(), run<double, 2>(scene, 80, true).values.front()) > 1e-5);
}

TEST_CASE("every shape, two rounds and single precision follow the host's") {
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::cubic}) {
        CAPTURE(int(shape));
        Scene scene = turning_on_slope(2);
        scene.shape = shape, scene.cfl = 0.2;
        compare_felt(scene, 60, 1e-8);
    }
    Scene rounds = turning_on_slope(2);
    rounds.transfer = Transfer::apic, rounds.stress_update = StressUpdate::musl;
    compare_felt(rounds, 60, 1e-8);
    for (Bed bed : {Bed::nodes, Bed::surface}) {
        Scene single = turning_on_slope(3);
        single.bed = bed, single.precision = Precision::single_;
        compare_felt(single, 30, 1e-4);
    }
}

TEST_CASE("a restart goes on with how they were turned") {
    Scene scene = on_surface(turning_on_slope(2));
    compare_restart<2>(scene, 43, 37, [](const auto& straight, const auto& restarted) {
        CHECK(restarted.structures().state(1).turned.e[0] == straight.structures().state(1).turned.e[0]);
    });
}
