#include <doctest/doctest.h>

#include <map>

#include "lattice_scenes.hpp"
#include "material_scenes.hpp"
#include "seeding/lattice_seeds.hpp"
#include "seeding/property_profile.hpp"
#include "seeding/seed.hpp"
#include "simulation/diagnostics.hpp"

using namespace moraine;

// A strength over depth is set where a particle begins and goes with it, on any ranks; and a profile that is the same
// number everywhere is that number, to the bit.

namespace {

const ProfileSpec& first_profile(const Scene& scene, int body) {
    return scene.materials[static_cast<std::size_t>(scene.bodies[static_cast<std::size_t>(body)].material)].profiles[0];
}

/// The strength of each particle at the start, by its id.
std::map<std::uint64_t, double> strengths_of(const Scene& scene) {
    std::map<std::uint64_t, double> all;
    for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b) {
        const BodySeeds body(scene, b);
        std::vector<Seed> seeds;
        body.fill(0, body.rows(), body.count(0, body.rows()), seeds);
        for (const Seed& s : seeds)
            all[s.id] = profile_at(scene, scene.bodies[static_cast<std::size_t>(b)], first_profile(scene, b), s.x);
    }
    return all;
}

/// Of the state without the column that only one of two scenes has.
template <class Real, int Dim>
std::uint64_t hash_without(const Simulation<Real, Dim>& sim, const std::string& left_out) {
    std::uint64_t sum = 0;
    sim.each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
        std::vector<ColumnBytes> columns = piece.columns;
        std::erase_if(columns, [&](const ColumnBytes& c) { return c.name == left_out; });
        for (int b = piece.begin; b < piece.end; ++b)
            for (std::uint32_t s : piece.slots(b))
                sum += row_hash(piece.tables.own[static_cast<std::size_t>(b)], columns, s);
    });
    return sim.comm().sum(sum);
}

struct Ended {
    std::uint64_t lists, rest;
    double time, plastic;
    bool operator==(const Ended&) const = default;
};

template <class Real, int Dim>
Ended run(const Scene& scene, const Comm& comm, int steps, const std::string& left_out = "") {
    Simulation<Real, Dim> sim(scene, comm);
    sim.seed();
    for (int n = 0; n < steps; ++n) sim.step(), sim.balance();
    sim.conclude();
    const auto p = sim.patch().particles.view();
    double plastic = 0;
    for (std::uint32_t s : sim.patch().binned().slot) plastic = std::max(plastic, static_cast<double>(p.history[0][s]));
    return {state_hash(sim, true), hash_without(sim, left_out), sim.clock().time, comm.max(plastic)};
}

template <class Real, int Dim>
void same_on_all_ranks(Scene scene) {
    const Comm all(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    scene.balance.trigger = Trigger::never;
    const Ended alone = run<Real, Dim>(scene, self, 25);
    CHECK(alone.plastic > 0.01);
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 5;
    for (const char* partitioner : {"morton", "shuffle"}) {
        scene.balance.partitioner = partitioner;
        CHECK(run<Real, Dim>(scene, all, 25) == alone);
    }
}

}  // namespace

TEST_CASE("properties over depth give one answer on any ranks") {
    same_on_all_ranks<double, 2>(test::soils_over_depth(2, 4));
    same_on_all_ranks<float, 2>(test::soils_over_depth(2, 4));
    same_on_all_ranks<double, 3>(test::soils_over_depth(3, 4));
    same_on_all_ranks<double, 2>(test::soils_of_own(2));
    same_on_all_ranks<double, 3>(test::soils_of_own(3));
}

TEST_CASE("interfaces that follow the soil give one answer on any ranks, and another one than a number") {
    const Comm all(MPI_COMM_WORLD);
    for (const Bed bed : {Bed::nodes, Bed::surface}) {
        CAPTURE(int(bed));
        Scene flat = test::clays_on_slope(2), deep = test::clays_on_slope(3);
        flat.bed = deep.bed = bed;
        same_on_all_ranks<double, 2>(flat);
        same_on_all_ranks<double, 3>(deep);
        Scene number = flat;
        number.structures[0].soil_su = false;
        CHECK(run<double, 2>(number, all, 25).rest != run<double, 2>(flat, all, 25).rest);
    }
}

TEST_CASE("a particle keeps the strength of the place where it began") {
    const Comm all(MPI_COMM_WORLD);
    Scene scene = test::soils_over_depth(2, 4);
    scene.balance.partitioner = "shuffle";
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 5;
    const std::map<std::uint64_t, double> expected = strengths_of(scene);
    Simulation<double, 2> sim(scene, all);
    sim.seed();
    for (const int steps : {0, 25}) {
        for (int n = 0; n < steps; ++n) sim.step(), sim.balance();
        sim.conclude();
        const ParticleView<double, 2> p = sim.patch().particles.view();
        std::int64_t count = 0, wrong = 0;
        for (std::uint32_t s : sim.patch().binned().slot) {
            const int material = scene.bodies[p.body[s]].material;
            ++count;
            wrong += p.history[material == 0 ? 2 : 1][s] != expected.at(p.id[s]);
        }
        CHECK(wrong == 0);
        CHECK(all.sum(count) == static_cast<std::int64_t>(expected.size()));
    }
}

TEST_CASE("a profile that is one number where the particles are gives the bits of that number") {
    const Comm all(MPI_COMM_WORLD);
    ProfileSpec table;
    table.depth = {0, 50, 60};
    table.value = {700, 700, 1e5};  // no body is that deep
    Scene clay = test::column();
    clay.materials.erase(clay.materials.begin() + 1);
    clay.bodies.erase(clay.bodies.begin() + 1);
    for (const char* law : {"von-mises", "tresca"}) {
        CAPTURE(law);
        clay.materials[0] = test::material(
            law, 1500, {{"young", 1e6}, {"poisson", 0.4}, {"su", 700}, {"sensitivity", 3}, {"xi95", 0.5}});
        Scene varied = clay;
        set_profile(varied.materials[0], 2, table);
        const Ended number = run<double, 3>(clay, all, 30), column = run<double, 3>(varied, all, 30, "history_1");
        CHECK(number.plastic > 0.001);
        CHECK(column.rest == number.rest);
        CHECK(column.time == number.time);
        CHECK(run<float, 3>(varied, all, 30, "history_1").rest == run<float, 3>(clay, all, 30).rest);
        varied.materials[0].profiles[0].value[1] = 701;
        CHECK(run<double, 3>(varied, all, 30, "history_1").rest != number.rest);
    }
    clay.materials[0] = test::material("drucker-prager", 1500,
                                       {{"young", 1e6}, {"poisson", 0.3}, {"friction_angle", 20}, {"cohesion", 700}});
    Scene varied = clay;
    set_profile(varied.materials[0], 4, table);
    CHECK(run<double, 3>(varied, all, 30, "history_2").rest == run<double, 3>(clay, all, 30).rest);
}

TEST_CASE("lattices with a strength over depth are made by rows") {
    const Comm all(MPI_COMM_WORLD);
    Scene scene = test::odd_boxes();
    scene.gravity = {0, -9.81, 0};
    for (MaterialSpec& m : scene.materials)
        m = test::material("tresca", 1500, {{"young", 1e6}, {"poisson", 0.4}, {"su", 700}});
    CHECK(is_lattice(scene));
    for (MaterialSpec& m : scene.materials) test::vary(m, "su", 300, 150);
    CHECK(!is_lattice(scene));
    std::uint64_t hash[2];
    for (const bool in_place : {false, true}) {
        Simulation<double, 2> sim(scene, all);
        sim.seed_in_place(in_place);
        sim.seed();
        hash[in_place] = state_hash(sim, true);
    }
    CHECK(hash[0] == hash[1]);
}
