#include <doctest/doctest.h>

#include "app/device.hpp"
#include "lattice_scenes.hpp"
#include "simulation/diagnostics.hpp"

using namespace moraine;

// A lattice that a kernel makes on the device has the bits of the one that the host makes by rows and uploads.

namespace {

struct Outcome {
    std::uint64_t lists, state;
    double signal, time, mass, strain, energy;
    std::int64_t particles;
    bool operator==(const Outcome&) const = default;
};

template <class Real, int Dim>
Outcome run(const Scene& scene, const Comm& comm, const DeviceChoice& device, bool in_place, int steps) {
    Simulation<Real, Dim> sim(scene, comm, device.cuda ? device_engine_maker<Real, Dim>(scene, comm, device) : nullptr);
    sim.seed_in_place(in_place);
    sim.seed();
    for (int k = 0; k < steps; ++k) sim.step(), sim.balance();
    sim.conclude();
    const RunClock<Dim>& c = sim.clock();
    return {state_hash(sim, true), state_hash(sim), c.signal,       c.time,
            c.start_mass,          c.start_strain,  c.start_energy, comm.sum(sim.engine().census().particles)};
}

template <class Real, int Dim>
void compare(const Scene& scene, const DeviceChoice& device) {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    const Outcome host = run<Real, Dim>(scene, self, {}, false, 0);
    CHECK(run<Real, Dim>(scene, comm, device, false, 0) == host);
    CHECK(run<Real, Dim>(scene, comm, device, true, 0) == host);
    CHECK(run<Real, Dim>(scene, comm, device, true, 30) == run<Real, Dim>(scene, comm, device, false, 30));
}

/// More than one piece of what the host looks at (gpu/engine_share.cpp).
Scene large() {
    Scene s = test::without_jitter(test::column());
    s.max = {48, 48, 56};
    s.cell = 0.5;
    s.bodies[0].max = {24, 48, 40};
    s.bodies[1].min = {24, 16, 0};
    s.bodies[1].max = {42, 40, 24};
    return s;
}

}  // namespace

TEST_CASE("a lattice that is made on the device is the host's to the bit, and so are steps from there") {
    const Comm comm(MPI_COMM_WORLD);
    const DeviceChoice device = choose_device("cuda", comm);
    for (const Scene& scene : test::lattice_scenes()) {
        CAPTURE(scene.dimensions);
        CAPTURE(scene.bodies.size());
        CAPTURE(static_cast<int>(scene.shape));
        if (scene.dimensions == 2)
            compare<float, 2>(scene, device), compare<double, 2>(scene, device);
        else
            compare<float, 3>(scene, device), compare<double, 3>(scene, device);
    }
}

TEST_CASE("a share of several pieces is looked at as if it were one") {
    const Comm comm(MPI_COMM_WORLD);
    const DeviceChoice device = choose_device("cuda", comm);
    compare<float, 3>(large(), device);
}
