#include <doctest/doctest.h>

#include "lattice_scenes.hpp"
#include "seeding/lattice_seeds.hpp"
#include "simulation/diagnostics.hpp"

using namespace moraine;

// Lattices that every owner makes for itself have the bits of those that are made by rows and sent.

namespace {

struct Start {
    std::uint64_t lists, state;
    std::int64_t particles;
    double signal, mass_cutoff, quantum, mass, strain, energy;
    bool operator==(const Start&) const = default;
};

template <class Real, int Dim>
Start start_of(const Scene& scene, const Comm& comm, bool in_place, int steps) {
    Simulation<Real, Dim> sim(scene, comm);
    sim.seed_in_place(in_place);
    sim.seed();
    for (int n = 0; n < steps; ++n) sim.step(), sim.balance();
    sim.conclude();
    const RunClock<Dim>& c = sim.clock();
    return {state_hash(sim, true),
            state_hash(sim),
            comm.sum(sim.engine().census().particles),
            c.signal,
            c.mass_cutoff,
            c.quantum_scale,
            c.start_mass,
            c.start_strain,
            c.start_energy};
}

Start start_of(const Scene& scene, bool single, const Comm& comm, bool in_place, int steps) {
    if (scene.dimensions == 2)
        return single ? start_of<float, 2>(scene, comm, in_place, steps)
                      : start_of<double, 2>(scene, comm, in_place, steps);
    return single ? start_of<float, 3>(scene, comm, in_place, steps)
                  : start_of<double, 3>(scene, comm, in_place, steps);
}

}  // namespace

TEST_CASE("a lattice that is made in place is the one that is made by rows, to the bit") {
    const Comm all(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    for (const Scene& scene : test::lattice_scenes())
        for (bool single : {true, false}) {
            CAPTURE(scene.dimensions);
            CAPTURE(scene.bodies.size());
            CAPTURE(static_cast<int>(scene.shape));
            CAPTURE(single);
            REQUIRE(is_lattice(scene));
            const Start rows = start_of(scene, single, self, false, 0);
            CHECK(rows.particles > 100);
            CHECK(start_of(scene, single, self, true, 0) == rows);
            CHECK(start_of(scene, single, all, true, 0) == rows);
        }
}

TEST_CASE("and steps on from there are the same, under any partitioner") {
    const Comm all(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    for (Scene scene : {test::odd_boxes(), test::stacked_boxes()}) {
        const Start rows = start_of(scene, false, self, false, 12);
        for (const char* partitioner : {"morton", "shuffle", "slabs"}) {
            CAPTURE(partitioner);
            scene.balance.partitioner = partitioner;
            scene.balance.trigger = Trigger::every;
            scene.balance.interval = 5;
            scene.balance.weight = partitioner == std::string("morton") ? "cost" : "particles";
            CHECK(start_of(scene, false, all, true, 12) == rows);
        }
    }
}

TEST_CASE("a law's state of the start is in every particle, and the steps from there are the same on any ranks") {
    const Comm all(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    Scene scene = test::odd_boxes();
    for (MaterialSpec& material : scene.materials)
        material.law = "modified-cam-clay", material.parameters = {0.2, 0.04, 1.0, 0.3, 1.5, 1000};
    scene.bodies[0].start.over_consolidation_ratio = 3;
    scene.bodies[0].geostatic = true;
    scene.bodies[0].geostatic_surface = scene.max[1];
    scene.gravity[1] = -1000;
    CHECK(!is_lattice(scene));
    Simulation<double, 2> sim(scene, all);
    sim.seed();
    const ParticleView<double, 2> p = sim.patch().particles.view();
    std::int64_t deep = 0, wrong = 0;
    for (std::uint32_t s : sim.patch().binned().slot) {
        const double mean = -p.stress[s].trace() / 3, from = std::max(mean, 1000.0);
        const double q2 = 3 * invariants(p.stress[s]).j2, yield = (p.body[s] == 0 ? 3 : 1) * (from + q2 / from);
        const double e = 1.5 - 0.2 * std::log(yield / 1000) + 0.04 * std::log(yield / from);
        deep += mean > 2000;
        wrong += std::fabs(p.history[0][s] / yield - 1) > 1e-12 || std::fabs(p.history[1][s] - e) > 1e-12;
    }
    CHECK(wrong == 0);
    CHECK(all.sum(deep) > 50);
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 5;
    CHECK(start_of(scene, false, all, true, 12) == start_of(scene, false, self, true, 12));
}

TEST_CASE("jitter, other shapes and structures that clear are left to the rows") {
    Scene scene = test::odd_boxes();
    CHECK(is_lattice(scene));
    scene.structures.push_back({});
    CHECK(is_lattice(scene));
    scene.structures.back().clear = true;
    CHECK(!is_lattice(scene));
    CHECK(!is_lattice(test::slurry()));
    scene = test::odd_boxes();
    scene.bodies[1].shape = BodyShape::sphere;
    CHECK(!is_lattice(scene));
}
