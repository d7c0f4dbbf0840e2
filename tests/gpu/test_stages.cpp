#include "core/transfer/kernel_key.hpp"
#include "gpu/engine_pair.hpp"
#include "io/test_folder.hpp"
#include "material_scenes.hpp"
#include "records/checkpoint_state.hpp"
#include "staged_scene.hpp"
#include "turning_scene.hpp"

using namespace moraine;
using namespace moraine::test;

// Stages on the device: the host's answer but for rounding.

namespace {

template <class Real, int Dim>
std::unique_ptr<Simulation<Real, Dim>> staged(const Scene& scene, const Comm& comm, int steps, bool on_device) {
    const DeviceChoice device = on_device ? choose_device("cuda", comm) : DeviceChoice{};
    auto sim = std::make_unique<Simulation<Real, Dim>>(
        scene, comm, on_device ? device_engine_maker<Real, Dim>(scene, comm, device) : nullptr);
    sim->seed();
    run_stages(*sim, steps);
    sim->conclude();
    return sim;
}

/// steps: of each stage. Returns the device's fields.
template <class Real, int Dim>
std::vector<Values> compare_stages(const Scene& scene, int steps, double tolerance) {
    const Comm comm(MPI_COMM_WORLD);
    const auto host = staged<Real, Dim>(scene, comm, steps, false),
               device = staged<Real, Dim>(scene, comm, steps, true);
    const std::vector<Values> right = values_of(*host), found = values_of(*device);
    for (std::size_t k = 0; k < right.size(); ++k) {
        CAPTURE(right[k].name);
        CHECK(difference(right[k], found[k]) <= tolerance);
        if (right[k].name == "ln_J") CHECK(right[k].scale > 1e-3);  // of soil that nothing strains: rounding
    }
    for (std::size_t k = 0; k < scene.course.stages.size(); ++k) {
        CAPTURE(k);
        const StageBegin &a = host->clock().stages[k], &b = device->clock().stages[k];
        CHECK(b.time == doctest::Approx(a.time).epsilon(1e-6));
        CHECK(b.removed_mass == a.removed_mass);
        CHECK(b.added_mass == a.added_mass);
    }
    CHECK(state_hash(*device, true) == state_hash(*staged<Real, Dim>(scene, comm, steps, true), true));
    return found;
}

Scene staged_soils(int dimensions, int materials) {
    const BodySpec comes = dimensions == 2 ? box({18, 2, 0}, {20, 4, 0}, 0) : box({17, 2, 5}, {19, 4, 7}, 0);
    return in_stages(soils(dimensions, materials), comes);
}

}  // namespace

TEST_CASE("strengths, walls and damping change, and bodies come and go, as on the host") {
    compare_stages<double, 2>(in_stages(slurry(), box({0.5, 0, 0}, {1, 0.5, 0}, 0)), 40, 1e-8);
    for (int materials : {2, 3}) {
        CAPTURE(materials);
        compare_stages<double, 2>(staged_soils(2, materials), 30, 1e-8);
    }
    compare_stages<double, 3>(staged_soils(3, 2), 20, 1e-8);
    Scene rounds = staged_soils(2, 2);
    rounds.stress_update = StressUpdate::musl;
    compare_stages<double, 2>(rounds, 30, 1e-8);
    Scene single = staged_soils(3, 3);
    single.precision = Precision::single_;
    compare_stages<float, 3>(single, 15, 1e-4);
    compare_stages<double, 2>(in_stages(turning_on_slope(2), box({0.5, 1, 0}, {0.8, 1.2, 0}, 0)), 30, 1e-8);
}

TEST_CASE("what a stage weakens yields, on the device") {
    Scene scene = staged_soils(2, 2);
    const Comm comm(MPI_COMM_WORLD);
    const std::vector<Values> weak = values_of(*staged<double, 2>(scene, comm, 30, true));
    for (StageSpec& stage : scene.course.stages) stage.materials = scene.materials;
    CHECK(difference(weak.front(), values_of(*staged<double, 2>(scene, comm, 30, true)).front()) > 1e-5);
}

TEST_CASE("a strength that depends on the rate in one stage alone has a kernel that knows rates") {
    Scene scene = staged_soils(2, 2);
    REQUIRE(kernel_key(scene).laws[1].plain);
    const int rate = parameter_named(*find_law("von-mises"), "rate_log");
    scene.course.stages[1].materials[1].parameters[static_cast<std::size_t>(rate)] = 0.5;
    CHECK(!kernel_key(scene).laws[1].plain);
    compare_stages<double, 2>(scene, 30, 1e-8);
}

TEST_CASE("a restart in a stage goes on in it with the same bits") {
    Scene scene = in_stages(slurry(), box({0.5, 0, 0}, {1, 0.5, 0}, 0));
    scene.bodies[0].name = "heap", scene.bodies[1].name = "fill";
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const auto maker = device_engine_maker<double, 2>(scene, comm, choose_device("cuda", comm));
    Simulation<double, 2> straight(scene, comm, maker), restarted(scene, comm, maker);
    straight.seed();
    advance(straight, 30);
    straight.begin_stage();
    advance(straight, 15);
    save(straight, comm, folder / "state");
    load(restarted, comm, CheckpointReader(comm, folder / "state"), folder / "state");
    advance(straight, 15), advance(restarted, 15);
    CHECK(state_hash(restarted) == state_hash(straight));
    straight.begin_stage(), restarted.begin_stage();
    advance(straight, 20), advance(restarted, 20);
    CHECK(state_hash(restarted) == state_hash(straight));
}
