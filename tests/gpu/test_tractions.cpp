#include "gpu/restart_pair.hpp"
#include "loaded_scene.hpp"
#include "material_scenes.hpp"
#include "staged_scene.hpp"

using namespace moraine;
using namespace moraine::test;

// Tractions on the device: the host's answer but for rounding.

namespace {

/// Its tractions are those of its second stage.
Scene blocks_in_stages() {
    Scene scene = in_stages(blocks_under_load(2), box({0.2, 1.15, 0}, {0.3, 1.25, 0}, 0));
    scene.course.stages[1].tractions[0].pressure = 1000, scene.course.stages[1].tractions[1].shear[0] = 900;
    scene.course.stages[2].removes.clear();
    return scene;
}

/// A run in its stages, of so many steps each: its particles, and what tractions did.
std::pair<std::vector<Values>, std::vector<double>> outcome_of_stages(const Scene& scene, int steps, bool on_device) {
    const Comm comm(MPI_COMM_WORLD);
    Simulation<double, 2> sim(
        scene, comm, on_device ? device_engine_maker<double, 2>(scene, comm, choose_device("cuda", comm)) : nullptr);
    sim.seed();
    run_stages(sim, steps);
    const std::vector<Values> values = values_of(sim);
    const Budget<2>& budget = sim.budget();
    std::vector<double> did;
    for (const ExactSum& sum : {budget.load_work, budget.load_impulse[0], budget.load_impulse[1]})
        did.push_back(sim.quantum().value(sum));
    return {values, did};
}

}  // namespace

TEST_CASE("blocks under load give the host's answer, with each transfer") {
    for (int dimensions : {2, 3})
        for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::tpic, Transfer::aflip}) {
            CAPTURE(dimensions);
            CAPTURE(int(transfer));
            Scene scene = blocks_under_load(dimensions);
            scene.transfer = transfer;
            compare(scene, dimensions == 2 ? 100 : 40, 1e-8);
        }
}

TEST_CASE("blocks under load give the host's answer, with each shape and order of updates") {
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::cubic}) {
        CAPTURE(int(shape));
        Scene scene = blocks_under_load(2);
        scene.shape = shape, scene.cfl = 0.3;
        compare(scene, 80, 1e-8);
    }
    for (StressUpdate update : {StressUpdate::usf, StressUpdate::musl}) {
        CAPTURE(int(update));
        Scene scene = blocks_under_load(2);
        scene.stress_update = update;
        compare(scene, 80, 1e-8);
    }
    Scene cubic = blocks_under_load(3), rounds = blocks_under_load(2);
    cubic.shape = Shape::cubic, cubic.cfl = 0.3;
    compare(cubic, 30, 1e-8);
    rounds.transfer = Transfer::fmpm, rounds.cfl = 0.3;
    compare(rounds, 60, 1e-8);
}

TEST_CASE("blocks under load give the host's answer: one material, means of cells, own densities, single precision") {
    Scene one = blocks_under_load(3);
    one.bodies.pop_back(), one.materials.pop_back(), one.course.tractions.pop_back();
    compare(one, 40, 1e-8);
    one.materials[0].volumetric = Volumetric::cell;
    compare(one, 40, 1e-8);
    for (const int body : {0, 1}) {
        Scene own = blocks_under_load(2);
        vary(own.materials[static_cast<std::size_t>(body)], "density", 1400, 300);
        compare(own, 60, 1e-8);
    }
    Scene single = blocks_under_load(3);
    single.precision = Precision::single_;
    compare(single, 30, 1e-4);
}

TEST_CASE("tractions matter to the device") {
    Scene scene = blocks_under_load(2);
    const Outcome loaded = run<double, 2>(scene, 60, true);
    CHECK(loaded.budget.back() < -1);
    for (TractionSpec& t : scene.course.tractions) t.pressure = 0, t.shear = {};
    const Outcome bare = run<double, 2>(scene, 60, true);
    CHECK(bare.budget.back() == 0);
    CHECK(difference(loaded.values.front(), bare.values.front()) > 1e-4);
}

TEST_CASE("a shipped slope bears its surcharge on the device as on the host") {
    Scene scene = input("loaded_slope", {});
    scene.course.tractions[0].factor.times = {0, 0.2};
    compare(scene, 100, 1e-8);
}

TEST_CASE("stages change tractions on the device as on the host") {
    const Scene scene = blocks_in_stages();
    const auto [host, host_did] = outcome_of_stages(scene, 40, false);
    const auto [device, device_did] = outcome_of_stages(scene, 40, true);
    for (std::size_t k = 0; k < host.size(); ++k) {
        CAPTURE(host[k].name);
        CHECK(difference(host[k], device[k]) <= 1e-8);
    }
    for (std::size_t k = 0; k < host_did.size(); ++k)
        CHECK(device_did[k] == doctest::Approx(host_did[k]).epsilon(1e-7));
    Scene same = scene;
    for (StageSpec& stage : same.course.stages) stage.tractions = scene.course.tractions;
    const auto unchanged = outcome_of_stages(same, 40, true);
    CHECK(std::fabs(unchanged.second[1] - device_did[1]) > 1);
}

TEST_CASE("a restart goes on with how the soil under loads was deformed") {
    const auto also = [](auto& straight, auto& restarted) {
        const auto &a = straight.budget(), &b = restarted.budget();
        CHECK(straight.quantum().value(a.load_work) == restarted.quantum().value(b.load_work));
        CHECK(straight.quantum().value(a.load_impulse[1]) == restarted.quantum().value(b.load_impulse[1]));
    };
    compare_restart<2>(blocks_under_load(2), 43, 37, also);
    Scene deep = blocks_under_load(3);
    deep.transfer = Transfer::apic;
    compare_restart<3>(deep, 20, 20, also);
}
