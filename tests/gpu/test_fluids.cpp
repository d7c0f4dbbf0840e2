#include "gpu/restart_pair.hpp"

using namespace moraine;
using namespace moraine::test;

// Fluids with smoothed pressures and shifted particles on the device: the host's answer but for rounding.

namespace {

/// It matters in these runs.
template <class Real, int Dim>
double change_by_keys(const Scene& scene, int steps) {
    Scene plain = scene;
    for (MaterialSpec& m : plain.materials) m.pressure_smoothing = m.particle_shifting = 0;
    return difference(run<Real, Dim>(scene, steps, true).values.front(),
                      run<Real, Dim>(plain, steps, true).values.front());
}

}  // namespace

TEST_CASE("one fluid with quadratic splines, gather and stress in one kernel, gives the host's answer") {
    for (Transfer transfer : {Transfer::flip, Transfer::pic, Transfer::apic, Transfer::tpic}) {
        CAPTURE(int(transfer));
        for (auto [smoothing, shifting] : {std::pair{0.22, 0.0}, {0.0, 0.1}, {0.22, 0.1}}) {
            CAPTURE(smoothing);
            CAPTURE(shifting);
            Scene scene = with_fluid_terms(slurry(), smoothing, shifting);
            scene.transfer = transfer;
            compare(scene, 100, 1e-9);
            CHECK(change_by_keys<double, 2>(scene, 20) > 1e-6);
        }
        Scene space = with_fluid_terms(input("slurry_runout_3d", {"numerics.precision=double", "domain.cell=0.5"}));
        space.transfer = transfer;
        compare(space, 60, 1e-9);
    }
}

TEST_CASE("shapes, transfers and schemes of fluids among other materials give the host's answer") {
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::quadratic, Shape::cubic})
        for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::aflip})
            for (StressUpdate scheme : {StressUpdate::usl, StressUpdate::usf, StressUpdate::musl}) {
                if (shape == Shape::linear && transfer != Transfer::flip) continue;
                CAPTURE(int(shape));
                CAPTURE(int(transfer));
                CAPTURE(int(scheme));
                for (Scene scene : {with_fluid_terms(slurry()), with_fluid_terms(fluid_column())}) {
                    scene.shape = shape;
                    scene.transfer = transfer;
                    scene.stress_update = scheme;
                    scene.cfl = shape == Shape::linear ? 0.05 : 0.2;  // hats turn particles inside out
                    if (transfer == Transfer::aflip) scene.flip = 0.95;
                    compare(scene, 40, 1e-8);
                }
            }
}

TEST_CASE("means of cells of one material beside shifts of another give the host's answer, and so does FMPM") {
    for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::fmpm}) {
        Scene scene = with_fluid_terms(fluid_column());
        scene.transfer = transfer;
        scene.cfl = 0.2;
        if (transfer != Transfer::fmpm) scene.materials[1].volumetric = Volumetric::cell;
        compare(scene, 40, 1e-8);
    }
}

TEST_CASE("films and droplets of fluids, whose light nodes are limited, give the host's answer") {
    for (int dimensions : {2, 3})
        for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::aflip})
            for (bool alone : {false, true}) {
                Scene scene = with_fluid_terms(wet_spray(dimensions, alone));
                scene.transfer = transfer;
                if (transfer == Transfer::aflip) scene.flip = 0.95;
                CAPTURE(dimensions);
                CAPTURE(int(transfer));
                CAPTURE(alone);
                compare(scene, 60, 1e-8);
                scene.limits_light_nodes = false;
                compare(scene, 20, 1e-8);
            }
}

TEST_CASE("nothing is shifted near structures, and layers on them give the host's answer") {
    for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
        Scene flat = with_fluid_terms(layers_on_slope(2)), deep = with_fluid_terms(layers_on_slope(3));
        flat.transfer = deep.transfer = transfer;
        compare(flat, 60, 1e-8);
        compare(deep, 30, 1e-8);
        flat.stress_update = StressUpdate::musl;
        compare(flat, 60, 1e-8);
    }
}

TEST_CASE("fluids in single precision follow the host's") {
    for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::aflip}) {
        Scene flat = with_fluid_terms(slurry()), deep = with_fluid_terms(fluid_column());
        for (Scene* scene : {&flat, &deep}) {
            scene->transfer = transfer;
            scene->precision = Precision::single_;
            compare(*scene, 30, 1e-4);
        }
    }
}

TEST_CASE("a restart between two shifts goes on with the same bits") {
    Scene scene = with_fluid_terms(slurry());
    scene.transfer = Transfer::aflip;
    scene.flip = 0.95;
    for (int before : {12, 14, 15}) {
        CAPTURE(before);
        compare_restart<2>(scene, before, 30 - before);
    }
}
