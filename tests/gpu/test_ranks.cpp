#include <doctest/doctest.h>

#include <cstdlib>

#include "app/device.hpp"
#include "comm/transport_names.hpp"
#include "ends_scene.hpp"
#include "gpu/transport/transport.hpp"
#include "loaded_scene.hpp"
#include "material_scenes.hpp"
#include "sample_scenes.hpp"
#include "simulation/diagnostics.hpp"
#include "sleep_scene.hpp"
#include "staged_scene.hpp"
#include "surface_scenes.hpp"
#include "turning_scene.hpp"

using namespace moraine;

// A run on devices gives the same bits whoever owns what and however it travels. Ranks share a device where they must.

namespace {

struct Outcome {
    std::uint64_t hash;
    std::array<double, 8> budget;
    double over_filling;
    RunCounts counts;
};

template <class Real, int Dim>
Outcome run(const Scene& scene, const Comm& comm, const DeviceChoice& device, int steps) {
    Simulation<Real, Dim> sim(scene, comm, device_engine_maker<Real, Dim>(scene, comm, device));
    sim.seed();
    if (sim.stage())
        test::run_stages(sim, steps);
    else
        for (int k = 0; k < steps; ++k) sim.step(), sim.balance();
    sim.conclude();
    const Budget<Dim>& l = sim.budget();
    const double lost = comm.sum(static_cast<double>(l.lost_count));
    RunCounts counts = sim.counts_so_far();
    counts.crossed_particles = comm.sum(counts.crossed_particles);
    counts.migrated_particles = comm.sum(counts.migrated_particles);
    counts.halo_bytes = comm.sum(counts.halo_bytes);
    counts.blocks_between_hosts_sum = comm.sum(counts.blocks_between_hosts_sum);
    return {state_hash(sim, true),
            {sum_of(sim, l.work), sum_of(sim, l.impulse[0]), sum_of(sim, l.impulse[1]), sum_of(sim, l.lost_mass),
             sum_of(sim, l.lost_momentum[0]), sum_of(sim, l.load_work), sum_of(sim, l.load_impulse[Dim - 1]), lost},
            comm.exact_sum(sim.answer(VolumeQuery{}).volumes).over_filling(),
            counts};
}

/// MORAINE_PRETEND_HOSTS while it lives: `mixed` is for several hosts, the others for what there is.
class HostsFor {
  public:
    explicit HostsFor(const std::string& transport) {
        if (transport == "mixed") setenv("MORAINE_PRETEND_HOSTS", "0,1,0,1", 1);
    }
    HostsFor(const HostsFor&) = delete;
    HostsFor& operator=(const HostsFor&) = delete;
    ~HostsFor() { unsetenv("MORAINE_PRETEND_HOSTS"); }
};

/// One rank's answer against that of all, for every transport and several ways to own the blocks.
template <class Real, int Dim>
void compare(Scene scene, int steps) {
    const Comm all(MPI_COMM_WORLD), alone(MPI_COMM_SELF);
    const DeviceChoice single = choose_device("cuda", alone);
    const Outcome expected = run<Real, Dim>(scene, alone, single, steps);
    for (const std::string_view name : transport_names) {
        const std::string transport(name);
        const HostsFor hosts(transport);
        DeviceChoice device;
        try {
            device = choose_device("cuda", all, transport);
        } catch (const InputError&) {
            continue;  // tests/gpu/test_transport.cpp has what must be there
        }
        CHECK(device.transport == transport);
        for (const char* partitioner : {"morton", "slabs", "shuffle"}) {
            CAPTURE(transport);
            CAPTURE(partitioner);
            scene.balance.partitioner = partitioner;
            scene.balance.trigger = Trigger::every;
            scene.balance.interval = 10;
            const Outcome found = run<Real, Dim>(scene, all, device, steps);
            CHECK(found.hash == expected.hash);
            CHECK(found.over_filling == expected.over_filling);
            for (std::size_t k = 0; k < expected.budget.size(); ++k) {
                CAPTURE(k);
                CHECK(found.budget[k] == expected.budget[k]);
            }
            CHECK(found.counts.halo_bytes > 0);
            CHECK((found.counts.blocks_between_hosts_sum > 0) == (transport == "mixed"));
            if (std::string(partitioner) != "shuffle") continue;
            CHECK(found.counts.crossed_particles > 0);
            CHECK(found.counts.migrated_particles > 0);
        }
    }
}

template <int Dim>
void compare(const Scene& scene, int steps) {
    if (scene.precision == Precision::single_)
        compare<float, Dim>(scene, steps);
    else
        compare<double, Dim>(scene, steps);
}

}  // namespace

TEST_CASE("a slurry that flows out through an open wall ends with the same bits on any number of devices") {
    for (Precision precision : {Precision::single_, Precision::double_}) {
        Scene scene = test::slurry();
        scene.precision = precision;
        compare<2>(scene, 80);
    }
}

TEST_CASE("two soils in 3-D with a periodic axis end with the same bits on any number of devices") {
    for (Precision precision : {Precision::single_, Precision::double_}) {
        Scene scene = test::column();
        scene.precision = precision;
        compare<3>(scene, 40);
    }
}

TEST_CASE("layers of two and three materials end with the same bits on any number of devices") {
    for (int materials : {2, 3})
        for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
            Scene plane = test::soils(2, materials), space = test::soils(3, materials);
            plane.transfer = space.transfer = transfer;
            space.precision = Precision::single_;
            compare<2>(plane, 80);
            compare<3>(space, 40);
        }
}

TEST_CASE("columns that only some scenes have travel too: affine fields, boxes, stretches, two rounds") {
    Scene affine = test::slurry();
    affine.transfer = Transfer::apic;
    affine.stress_update = StressUpdate::musl;
    compare<2>(affine, 40);
    affine.transfer = Transfer::aflip;
    affine.flip = 0.95;
    compare<2>(affine, 40);
    Scene series = test::slurry();
    series.transfer = Transfer::fmpm;
    series.order = 3;
    series.cfl = 0.3;
    compare<2>(series, 40);
    Scene rates = test::slurry();
    rates.materials[0].volumetric = Volumetric::cell;
    compare<2>(rates, 40);
    Scene boxes = test::column();
    boxes.shape = Shape::gimp_contiguous;
    boxes.precision = Precision::single_;
    compare<3>(boxes, 30);
    Scene cubic = test::column();
    cubic.shape = Shape::cubic;
    cubic.transfer = Transfer::apic;
    cubic.materials[0] = test::material("neo-hookean", 1000, {{"young", 1e6}, {"poisson", 0.3}});
    compare<3>(cubic, 30);
}

TEST_CASE("thin layers on structures that rest, move and are free end with the same bits on any number of devices") {
    for (Precision precision : {Precision::single_, Precision::double_}) {
        Scene flat = test::layers_on_slope(2), deep = test::layers_on_slope(3);
        flat.precision = deep.precision = precision;
        compare<2>(flat, 120);
        compare<3>(deep, 60);
    }
    for (Shape shape : {Shape::linear, Shape::gimp_contiguous, Shape::cubic}) {
        Scene scene = test::layers_on_slope(2);
        scene.shape = shape;
        scene.cfl = 0.2;
        compare<2>(scene, 60);
    }
    Scene rounds = test::layers_on_slope(2);
    rounds.transfer = Transfer::apic;
    rounds.stress_update = StressUpdate::musl;
    compare<2>(rounds, 60);
}

TEST_CASE(
    "structures that turn, told and free, at nodes and on surfaces, give the same bits on any number of devices") {
    for (Bed bed : {Bed::nodes, Bed::surface}) {
        Scene flat = test::turning_on_slope(2), deep = test::turning_on_slope(3);
        flat.bed = deep.bed = bed;
        deep.precision = Precision::single_;
        compare<2>(flat, 80);
        compare<3>(deep, 40);
    }
}

TEST_CASE("bodies come and go in stages with the same bits on any number of devices") {
    compare<2>(test::in_stages(test::slurry(), test::box({0.5, 0, 0}, {1, 0.5, 0}, 0)), 40);
    Scene soils = test::in_stages(test::soils(3, 2), test::box({17, 2, 5}, {19, 4, 7}, 0));
    soils.precision = Precision::single_;
    compare<3>(soils, 20);
}

TEST_CASE("ends absorb with the same bits on any number of devices") {
    compare<2>(test::ground_on_ends(2), 60);
    Scene deep = test::ground_on_ends(3);
    deep.precision = Precision::single_;
    compare<3>(deep, 40);
}

TEST_CASE("tractions act with the same bits on any number of devices") {
    compare<2>(test::blocks_under_load(2), 80);
    Scene deep = test::blocks_under_load(3);
    deep.precision = Precision::single_;
    compare<3>(deep, 40);
}

TEST_CASE("a bed that falls asleep and is struck ends with the same bits on any number of devices") {
    compare<2>(test::bed(2), 240);
    Scene deep = test::bed(3);
    deep.precision = Precision::single_;
    compare<3>(deep, 160);
    Scene mud = test::mud();
    mud.substeps = 4;
    compare<2>(mud, 120);
}

TEST_CASE("the tiles of sleepers are sent once") {
    const Comm all(MPI_COMM_WORLD);
    const DeviceChoice device = choose_device("cuda", all);
    Scene scene = test::bed(2);
    scene.balance.trigger = Trigger::never;
    const auto bytes = [&](int steps) { return run<double, 2>(scene, all, device, steps).counts.halo_bytes; };
    const std::int64_t asleep = bytes(120), longer = bytes(160);
    scene.sleep.on = false;
    const std::int64_t awake = bytes(160) - bytes(120);
    MESSAGE("halo of 40 steps, asleep and awake: " << longer - asleep << " and " << awake << " bytes");
    CHECK(longer - asleep < awake);
}

TEST_CASE("a valley whose bed varies ends with the same bits on any number of devices") {
    for (Precision precision : {Precision::single_, Precision::double_}) {
        Scene scene = test::small_valley(InterfaceLaw::voellmy, true);
        scene.precision = precision;
        compare<3>(scene, 60);
    }
}

TEST_CASE("light nodes are limited alike whoever owns their tiles") {
    for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
        Scene plane = test::spray(2), space = test::spray(3);
        plane.transfer = space.transfer = transfer;
        space.precision = Precision::single_;
        space.materials.pop_back();
        for (BodySpec& b : space.bodies) b.material = 0;
        compare<2>(plane, 60);
        compare<3>(space, 40);
    }
}

TEST_CASE("pressures are smoothed and particles shifted alike whoever owns their nodes") {
    for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::aflip})
        for (Precision precision : {Precision::single_, Precision::double_}) {
            Scene plane = test::with_fluid_terms(test::slurry()), space = test::with_fluid_terms(test::fluid_column());
            plane.transfer = space.transfer = transfer;
            plane.precision = space.precision = precision;
            compare<2>(plane, 60);
            compare<3>(space, 30);
        }
    Scene slope = test::with_fluid_terms(test::layers_on_slope(2)),
          film = test::with_fluid_terms(test::wet_spray(2, true));
    slope.stress_update = StressUpdate::musl;
    compare<2>(slope, 60);
    film.transfer = Transfer::apic;
    compare<2>(film, 60);
}

TEST_CASE("pressures of cells and their substeps are the same whoever owns the cells") {
    for (Transfer transfer : {Transfer::apic, Transfer::aflip})
        for (int substeps : {1, 10}) {
            Scene scene = test::with_fluid_terms(test::slurry());
            scene.materials[0].volumetric = Volumetric::grid;
            scene.materials[0].parameters[1] = 0.49;
            scene.substeps = substeps;
            scene.transfer = transfer;
            compare<2>(scene, 40);
        }
    Scene space = test::with_fluid_terms(test::wet_spray(3, true));
    space.materials[0].volumetric = Volumetric::grid;
    space.precision = Precision::single_;
    compare<3>(space, 30);
}

TEST_CASE("surfaces that act where they are do so alike whoever owns the blocks that they cut") {
    for (Precision precision : {Precision::single_, Precision::double_}) {
        Scene flat = test::on_surface(test::layers_on_slope(2)), deep = test::on_surface(test::layers_on_slope(3)),
              valley = test::on_surface(test::small_valley(InterfaceLaw::voellmy, true));
        flat.precision = deep.precision = valley.precision = precision;
        compare<2>(flat, 80);
        compare<3>(deep, 40);
        compare<3>(valley, 60);
    }
    compare<2>(test::wet(test::slurry_on_plane(InterfaceLaw::coulomb, 20), 4), 60);
    Scene valley = test::wet_valley(3);
    valley.precision = Precision::single_;
    compare<3>(valley, 40);
}

TEST_CASE("sleepers beside surfaces end with the same bits on any number of devices") {
    compare<2>(test::on_surface(test::plate_over_bed(2)), 240);
    Scene mud = test::on_surface(test::mud());
    mud.structures = test::plate_over_bed(2).structures;
    mud.substeps = 4;
    compare<2>(mud, 80);
}
