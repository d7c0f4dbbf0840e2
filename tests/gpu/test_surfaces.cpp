#include "gpu/restart_pair.hpp"
#include "surface_scenes.hpp"

using namespace moraine;
using namespace moraine::test;

// Surfaces that act where they are: the host's answer but for rounding.

namespace {

/// By the first structure, of all steps.
std::vector<double> felt(const Scene& scene, int steps, bool on_device) {
    const Comm comm(MPI_COMM_WORLD);
    const DeviceChoice device = on_device ? choose_device("cuda", comm) : DeviceChoice{};
    Simulation<double, 2> sim(scene, comm, on_device ? device_engine_maker<double, 2>(scene, comm, device) : nullptr);
    sim.seed();
    advance(sim, steps);
    std::vector<double> sums;
    for (const ExactSum& sum : sim.structures().state(0).felt.sum) sums.push_back(sim.quantum().value(sum));
    return sums;
}

constexpr InterfaceLaw all_laws[] = {InterfaceLaw::smooth, InterfaceLaw::rough, InterfaceLaw::coulomb,
                                     InterfaceLaw::undrained, InterfaceLaw::voellmy};

}  // namespace

TEST_CASE("every law on a plane between the nodes, level and turned, gives the host's answer") {
    for (InterfaceLaw law : all_laws)
        for (double angle : {0.0, 20.0})
            for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
                CAPTURE(int(law));
                CAPTURE(angle);
                CAPTURE(int(transfer));
                Scene scene = slurry_on_plane(law, angle);
                scene.transfer = transfer;
                compare(scene, 80, 1e-8);
            }
}

TEST_CASE("surfaces matter to the device") {
    Scene scene = slurry_on_plane(InterfaceLaw::rough, 20);
    const Outcome surface = run<double, 2>(scene, 80, true);
    scene.bed = Bed::nodes;
    CHECK(difference(surface.values.front(), run<double, 2>(scene, 80, true).values.front()) > 1e-5);
    Scene valley = on_surface(small_valley(InterfaceLaw::voellmy, true));
    const Outcome of_valley = run<double, 3>(valley, 80, true);
    valley.bed = Bed::nodes;
    CHECK(difference(of_valley.values.front(), run<double, 3>(valley, 80, true).values.front()) > 1e-6);
}

TEST_CASE("structures that rest, move and are free give the host's answer") {
    for (int dimensions : {2, 3}) {
        CAPTURE(dimensions);
        compare(on_surface(layers_on_slope(dimensions)), dimensions == 2 ? 80 : 40, 1e-8);
    }
}

TEST_CASE("every law of the ground, with rasters, gives the host's answer") {
    for (InterfaceLaw law : all_laws) {
        CAPTURE(int(law));
        compare(on_surface(small_valley(law, true)), 80, 1e-8);
    }
}

TEST_CASE("fluids with cells' pressures on planes and in a valley give the host's answer") {
    for (InterfaceLaw law : all_laws)
        for (int substeps : {1, 10}) {
            CAPTURE(int(law));
            CAPTURE(substeps);
            compare(wet(slurry_on_plane(law, 20), substeps), 60, 1e-8);
        }
    Scene level = wet(slurry_on_plane(InterfaceLaw::smooth, 0), 4);
    level.transfer = Transfer::aflip, level.flip = 0.95;
    compare(level, 60, 1e-8);
    compare(wet_valley(4), 40, 1e-8);
}

TEST_CASE("structures feel what they feel on the host") {
    for (bool cells : {false, true}) {
        CAPTURE(cells);
        const Scene scene =
            cells ? wet(slurry_on_plane(InterfaceLaw::coulomb, 20), 4) : slurry_on_plane(InterfaceLaw::coulomb, 20);
        const std::vector<double> host = felt(scene, 80, false), device = felt(scene, 80, true);
        for (std::size_t k = 0; k < host.size(); ++k) {
            CAPTURE(k);
            CHECK(device[k] == doctest::Approx(host[k]).epsilon(1e-6).scale(1e-3 * std::fabs(host[1])));
        }
        CHECK(std::fabs(host[1]) > 10);
    }
}

TEST_CASE("fluids smoothed and shifted by their particles give the host's answer") {
    compare(with_fluid_terms(slurry_on_plane(InterfaceLaw::rough, 20)), 60, 1e-8);
}

TEST_CASE("single precision follows the host's") {
    Scene flat = slurry_on_plane(InterfaceLaw::coulomb, 20),
          deep = on_surface(small_valley(InterfaceLaw::voellmy, true));
    for (BodySpec& body : deep.bodies) body.velocity = {2, 0.3, -8};  // on the ground early in the few steps
    flat.precision = deep.precision = Precision::single_;
    compare(flat, 40, 1e-4);
    compare(deep, 40, 1e-4);
}

TEST_CASE("a restart goes on with the same bits") {
    Scene scene = on_surface(layers_on_slope(2));
    scene.materials.pop_back();
    scene.bodies[1].material = 0;
    compare_restart<2>(scene, 33, 27);
}

TEST_CASE("what surfaces cut is kept over epochs, and is that of a run that begins in the midst of them") {
    compare_restart<3>(on_surface(small_valley(InterfaceLaw::coulomb, true)), 90, 40);
    compare_restart<3>(wet_valley(2), 50, 30);
}
