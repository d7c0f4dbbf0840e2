#include <cmath>

#include "core/data/plan_samples.hpp"
#include "gpu/engine_pair.hpp"
#include "terrain_scene.hpp"

using namespace moraine;
using namespace moraine::test;

// Ground, its laws and what maps and sections ask of particles: the device's answer is the host's.

namespace {

/// The simulation refers to the scene, which must outlive it.
template <class Real>
std::unique_ptr<Simulation<Real, 3>> started(const Scene& scene, const Comm& comm, const DeviceChoice& device) {
    auto sim = std::make_unique<Simulation<Real, 3>>(
        scene, comm, device.cuda ? device_engine_maker<Real, 3>(scene, comm, device) : nullptr);
    sim->seed();
    return sim;
}

/// All tiles of a map, the last first; `tiles` has their numbers and must outlive it.
template <class Real>
PlanColumns columns_of(const Simulation<Real, 3>& sim, double side, std::vector<std::int32_t>& tiles) {
    PlanColumns c{};
    c.places = sim.plan_places();
    c.side = side;
    for (int a = 0; a < 2; ++a) {
        c.corner[a] = sim.scene().min[static_cast<std::size_t>(a)];
        c.size[a] = std::llround(std::ceil(sim.scene().max[static_cast<std::size_t>(a)] / side));
        c.count[a] = (c.size[a] + PlanColumns::edge - 1) / PlanColumns::edge;
    }
    c.tiles = c.count[0] * c.count[1];
    tiles.resize(static_cast<std::size_t>(c.tiles));
    for (std::size_t t = 0; t < tiles.size(); ++t) tiles[t] = static_cast<std::int32_t>(tiles.size() - 1 - t);
    c.tile = tiles.data();
    c.volume_unit = 1e-12, c.mass_unit = 1e-9, c.momentum_unit = 1e-7;
    return c;
}

/// The same sums by a plain loop over the share on the host.
template <class Real>
std::vector<std::int64_t> plain_sums(Simulation<Real, 3>& sim, const PlanColumns& columns, double& fastest) {
    std::vector<std::int64_t> sums(columns.all_sums(), 0);
    const ParticleView<Real, 3> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 3>& x) {
        const std::int64_t i = columns.along(0, x[0]), j = columns.along(1, x[1]);
        fastest = std::max(fastest, PlanColumns::square_of(p.velocity[s]));
        if (!columns.is_summed(columns.column(i, j), x[2])) return;
        columns.add_particle<Real>(
            double(p.volume[s]), double(p.mass[s]), p.velocity[s],
            [&](int q, std::int64_t whole) { sums[columns.place(i, j) + static_cast<std::size_t>(q)] += whole; });
    });
    return sums;
}

std::string fault_of(const Scene& scene, const DeviceChoice& device) {
    const Comm comm(MPI_COMM_WORLD);
    try {
        auto sim = started<double>(scene, comm, device);
        advance(*sim, 3);
    } catch (const PhysicsError& e) {
        return e.what();
    }
    return {};
}

}  // namespace

TEST_CASE("every law of the ground, with and without rasters, gives the host's answer") {
    for (InterfaceLaw law : {InterfaceLaw::voellmy, InterfaceLaw::coulomb, InterfaceLaw::undrained, InterfaceLaw::rough,
                             InterfaceLaw::smooth})
        for (bool rasters : {false, true}) {
            CAPTURE(int(law));
            CAPTURE(rasters);
            compare(small_valley(law, rasters), 80, 1e-8);
        }
}

TEST_CASE("rasters of the ground's law change the answer") {
    for (InterfaceLaw law : {InterfaceLaw::voellmy, InterfaceLaw::coulomb, InterfaceLaw::undrained}) {
        CAPTURE(int(law));
        const Outcome one = run<double, 3>(small_valley(law, false), 80, true);
        const Outcome many = run<double, 3>(small_valley(law, true), 80, true);
        CHECK(difference(one.values[0], many.values[0]) > 1e-6);
    }
}

TEST_CASE("ground gives the host's answer for every shape, in rounds, and in single precision") {
    // fast enough to be on the ground early in the few steps: what falls freely holds nothing but rounding
    Scene fast = small_valley(InterfaceLaw::voellmy, true);
    for (BodySpec& body : fast.bodies) body.velocity = {2, 0.3, -8};
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::cubic}) {
        CAPTURE(int(shape));
        Scene scene = fast;
        scene.shape = shape;
        scene.cfl = 0.2;
        compare(scene, 80, 1e-8);
    }
    Scene rounds = fast;
    rounds.transfer = Transfer::apic;
    rounds.stress_update = StressUpdate::musl;
    compare(rounds, 60, 1e-8);
    Scene single = fast;
    single.precision = Precision::single_;
    compare(single, 40, 1e-4);
}

TEST_CASE("fluids on ground, smoothed, shifted and with the grid's pressure, give the host's answer") {
    Scene wet = small_valley(InterfaceLaw::voellmy, true);
    wet.materials = {
        material("bingham", 1500,
                 {{"young", 1e6}, {"poisson", 0.49}, {"yield_stress", 100}, {"consistency", 10}, {"viscosity", 10}})};
    for (BodySpec& body : wet.bodies) body.material = 0;
    wet = with_fluid_terms(wet);
    compare(wet, 40, 1e-8);
    wet.materials[0].volumetric = Volumetric::grid;
    compare(wet, 40, 1e-8);
}

TEST_CASE("Voellmy's law on a plane in 2-D gives the host's answer") {
    Scene scene = layers_on_slope(2);
    scene.structures[0].law = InterfaceLaw::voellmy;
    scene.structures[0].friction = 0.2, scene.structures[0].xi = 300, scene.structures[0].density = 1500;
    compare(scene, 100, 1e-8);
}

TEST_CASE("who is buried in the ground ends the run with the host's words") {
    const Comm comm(MPI_COMM_WORLD);
    Scene scene = small_valley(InterfaceLaw::coulomb, false);
    scene.bodies.push_back(box({0.4, 0.3, 0.3}, {0.6, 0.5, 0.4}, 0));
    const std::string host = fault_of(scene, {}), device = fault_of(scene, choose_device("cuda", comm));
    CAPTURE(host);
    CAPTURE(device);
    CHECK(host.find("m is more than a cell under the ground") != std::string::npos);
    CHECK(device.substr(0, device.find(" (")) == host.substr(0, host.find(" (")));
}

TEST_CASE("sums of a map's columns are those of a plain loop, to the last whole number") {
    const Comm comm(MPI_COMM_WORLD);
    for (double side : {0.03, 0.2, 0.7}) {
        CAPTURE(side);
        const Scene scene = small_valley(InterfaceLaw::voellmy, true);
        auto host = started<double>(scene, comm, {});
        auto device = started<double>(scene, comm, choose_device("cuda", comm));
        std::vector<std::int32_t> tiles;
        PlanColumns columns = columns_of(*device, side, tiles);
        std::vector<std::int64_t> of_host(columns.all_sums(), 0), of_device(columns.all_sums(), 0);
        CHECK(host->answer(ColumnQuery{columns, of_host}).square_speed ==
              device->answer(ColumnQuery{columns, of_device}).square_speed);
        CHECK(of_host == of_device);
        advance(*device, 60);
        std::fill(of_device.begin(), of_device.end(), 0);
        double fastest = 0;
        const double told = device->answer(ColumnQuery{columns, of_device}).square_speed;
        CHECK(of_device == plain_sums(*device, columns, fastest));
        CHECK(told == fastest);

        std::vector<double> floor(columns.all());
        for (std::size_t k = 0; k < floor.size(); ++k) floor[k] = 0.5 + 0.003 * static_cast<double>(k % 50);
        columns.floor = floor.data();
        std::vector<Layers> layers(columns.all(), 0), plain(columns.all(), 0);
        device->answer(LayerQuery{columns, layers});
        each_particle(*device, [&](std::uint32_t, const std::array<double, 3>& x) {
            const std::size_t column = columns.column(columns.along(0, x[0]), columns.along(1, x[1]));
            plain[column] |= columns.layer(column, x[2]);
        });
        CHECK(layers == plain);
        for (Layers& l : layers) l &= 0x55;
        columns.resting = layers.data();
        std::fill(of_device.begin(), of_device.end(), 0);
        CHECK(device->answer(ColumnQuery{columns, of_device}).square_speed == told);
        CHECK(of_device == plain_sums(*device, columns, fastest));
    }
}

TEST_CASE("particles near lines are those of the host, also where they are more than a first list holds") {
    const Comm comm(MPI_COMM_WORLD);
    const Scene scene = small_valley(InterfaceLaw::voellmy, false);
    auto host = started<float>(scene, comm, {});
    auto device = started<float>(scene, comm, choose_device("cuda", comm));
    const PlanSegment segments[] = {{{0.5, 0}, {0.9, 1.2}}, {{0.9, 1.2}, {1.2, 0.1}}};
    const auto by_id = [](const NearParticle& a, const NearParticle& b) { return a.id < b.id; };
    const PlanLines lines{host->plan_places(), segments, 2, 0.15};
    std::vector<NearParticle> a = host->answer(LineQuery{lines, {}}).near;
    std::vector<NearParticle> b = device->answer(LineQuery{lines, {}}).near;
    std::sort(a.begin(), a.end(), by_id), std::sort(b.begin(), b.end(), by_id);
    CHECK(a.size() > 300);
    CHECK(a.size() < static_cast<std::size_t>(host->engine().census().particles));
    REQUIRE(a.size() == b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
        const bool same = a[k].id == b[k].id && a[k].x[0] == b[k].x[0] && a[k].x[1] == b[k].x[1] &&
                          a[k].volume == b[k].volume && a[k].mass == b[k].mass;
        CHECK(same);
    }
}
