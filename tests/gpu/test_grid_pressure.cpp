#include "gpu/restart_pair.hpp"

using namespace moraine;
using namespace moraine::test;

// Pressures of fluids on cells, with substeps and without: the host's answer but for rounding.

namespace {

/// All fluids nearly incompressible, so that a step has several substeps where they are allowed.
Scene with_grid_pressure(Scene s, int substeps, double smoothing = 0.22, double shifting = 0.1) {
    s = with_fluid_terms(s, smoothing, shifting);
    s.substeps = substeps;
    for (MaterialSpec& m : s.materials) {
        m.volumetric = Volumetric::grid;
        m.parameters[1] = 0.49;
    }
    return s;
}

/// Two fluids of other densities and stiffness.
Scene two_fluids() {
    Scene s = fluid_column();
    s.materials[1] = s.materials[2];
    s.materials.pop_back();
    s.bodies[2].material = 1;
    return s;
}

}  // namespace

TEST_CASE("one fluid, gather and stress in one kernel, gives the host's answer") {
    for (Transfer transfer : {Transfer::flip, Transfer::pic, Transfer::apic, Transfer::tpic})
        for (int substeps : {1, 4, 10})
            for (auto [smoothing, shifting] : {std::pair{0.0, 0.0}, {0.22, 0.0}, {0.0, 0.1}, {0.22, 0.1}}) {
                CAPTURE(int(transfer));
                CAPTURE(substeps);
                CAPTURE(smoothing);
                CAPTURE(shifting);
                Scene scene = with_grid_pressure(slurry(), substeps, smoothing, shifting);
                scene.transfer = transfer;
                compare(scene, 40, 1e-8);
            }
    for (int substeps : {1, 10}) {
        Scene space =
            with_grid_pressure(input("slurry_runout_3d", {"numerics.precision=double", "domain.cell=0.5"}), substeps);
        compare(space, 30, 1e-8);
    }
}

TEST_CASE("one fluid with AFLIP, whose stress is a launch of its own, and two fluids give the host's answer") {
    for (int substeps : {1, 10})
        for (Transfer transfer : {Transfer::aflip, Transfer::apic}) {
            CAPTURE(substeps);
            CAPTURE(int(transfer));
            Scene flat = with_grid_pressure(slurry(), substeps), deep = with_grid_pressure(two_fluids(), substeps);
            flat.transfer = deep.transfer = transfer;
            if (transfer == Transfer::aflip) flat.flip = deep.flip = 0.95;
            compare(flat, 40, 1e-8);
            compare(deep, 20, 1e-8);
        }
}

TEST_CASE("undrained clay, whose stress is a launch of its own, gives the host's answer") {
    for (const char* volumetric : {"grid", "particle"}) {
        CAPTURE(volumetric);
        const Scene slope =
            input("retrogressive_slope",
                  {"numerics.precision=double", "numerics.sleep=off", "domain.cell=1",
                   std::string("material.sensitive-clay.volumetric=") + volumetric,
                   "material.sensitive-clay.pressure_smoothing=0.22", "material.sensitive-clay.particle_shifting=0.1"});
        compare(slope, 40, 1e-8);
    }
}

TEST_CASE("the substeps are taken, and matter") {
    Scene scene = with_grid_pressure(slurry(), 10);
    const Outcome many = run<double, 2>(scene, 20, true);
    scene.substeps = 1;
    const Outcome one = run<double, 2>(scene, 20, true);
    CHECK(many.time > 4 * one.time);
    for (MaterialSpec& m : scene.materials) m.volumetric = Volumetric::particle;
    CHECK(difference(one.values.front(), run<double, 2>(scene, 20, true).values.front()) > 1e-5);
}

TEST_CASE("films and droplets, whose cells are not whole and whose nodes are light, give the host's answer") {
    for (int dimensions : {2, 3})
        for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::aflip})
            for (int substeps : {1, 10}) {
                CAPTURE(dimensions);
                CAPTURE(int(transfer));
                CAPTURE(substeps);
                Scene scene = with_grid_pressure(wet_spray(dimensions, true), substeps);
                scene.transfer = transfer;
                if (transfer == Transfer::aflip) scene.flip = 0.95;
                compare(scene, 40, 1e-8);
            }
}

TEST_CASE("layers on structures that rest, move and are free give the host's answer") {
    for (Transfer transfer : {Transfer::flip, Transfer::apic})
        for (int dimensions : {2, 3}) {
            Scene scene = layers_on_slope(dimensions);
            scene.materials.pop_back();
            scene.bodies[1].material = 0;
            scene = with_grid_pressure(scene, 1);
            scene.transfer = transfer;
            compare(scene, dimensions == 2 ? 40 : 20, 1e-8);
        }
}

TEST_CASE("single precision follows the host's") {
    for (Transfer transfer : {Transfer::apic, Transfer::aflip})
        for (int substeps : {1, 10}) {
            Scene scene = with_grid_pressure(slurry(), substeps);
            scene.precision = Precision::single_;
            scene.transfer = transfer;
            compare(scene, 20, 1e-4);
        }
}

TEST_CASE("a restart goes on with the same bits") {
    Scene scene = with_grid_pressure(slurry(), 10);
    scene.transfer = Transfer::apic;
    compare_restart<2>(scene, 13, 17);
}
