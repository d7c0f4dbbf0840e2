#include <doctest/doctest.h>

#include <cmath>

#include "records/hazard_maps.hpp"
#include "simulation/diagnostics.hpp"
#include "terrain_scene.hpp"

using namespace moraine;

// The volume in the maps is that of the particles, whatever comes in late and whatever leaves.

namespace {

BodySpec late(const Scene& s, double start, double x) {
    BodySpec body;
    body.name = "late", body.shape = BodyShape::layer, body.material = 0;
    body.ground = s.structures[0].ground;
    body.points = {{x, 0.2}, {x + 0.5, 0.2}, {x + 0.5, 1}, {x, 1}};
    body.thickness = 0.2;
    body.release_time = start;
    return body;
}

/// Layers that flow out by the open side x-max, and two releases with a start.
Scene leaving() {
    Scene s = test::small_valley(InterfaceLaw::voellmy, false);
    s.end = 1;
    s.max[0] = 1.6;
    s.structures.resize(1);
    for (BodySpec& body : s.bodies) body.velocity = {9, 0.3, -3};
    s.bodies.push_back(late(s, 0.05, 0.1));
    s.bodies.push_back(late(s, 0.08, 1));
    s.hazard.cell = 0.23;  // the last column is cut by the domain's end
    s.hazard.threshold = 0.02;
    s.hazard.maps = {"deposit"};
    return s;
}

/// Columns along an axis and the side of the last [m]: what is narrower than a cell is of the one before.
struct Cut {
    std::int64_t columns;
    double last;

    Cut(const Scene& s, std::size_t axis) {
        const double length = s.max[axis] - s.min[axis], a = s.hazard.cell;
        columns = std::llround(std::ceil(length / a - 1e-9));
        if (length - double(columns - 1) * a < s.cell - 1e-9) --columns;
        last = length - double(columns - 1) * a;
    }
    double side(std::int64_t index, double a) const { return index + 1 < columns ? a : last; }
};

/// What rank 0 stores, on all.
std::vector<double> stored_in(const HazardMaps& maps) {
    const Comm comm(MPI_COMM_WORLD);
    const std::vector<double> mine = maps.stored();
    return comm.all_gather(comm.is_root() ? mine : std::vector<double>{});
}

/// Of the last sample, from what a checkpoint keeps of the maps [m3].
double volume_in(const HazardMaps& maps, const Scene& s) {
    const std::vector<double> all = stored_in(maps);
    const Cut x(s, 0), y(s, 1);
    double sum = 0;
    for (std::size_t at = 1; at < all.size(); at += 7) {
        const std::int64_t k = std::llround(all[at]);
        sum += all[at + 6] * x.side(k % x.columns, s.hazard.cell) * y.side(k / x.columns, s.hazard.cell);
    }
    return sum;
}

template <class Real>
double volume_of(Simulation<Real, 3>& sim, const Comm& comm) {
    double sum = 0;
    const ParticleView<Real, 3> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 3>&) { sum += double(p.volume[s]); });
    return comm.sum(sum);
}

/// Whether somebody is so high over the ground that he may fly.
template <class Real>
bool flies(Simulation<Real, 3>& sim, const Comm& comm) {
    double most = 0;
    each_particle(sim, [&](std::uint32_t, const std::array<double, 3>& x) {
        const Vec<double, 3> at{{x[0], x[1], x[2]}};
        most = std::max(most, x[2] - ground_at<3>(sim.scene().structures[0].ground->table.data(), at).height);
    });
    return comm.max(most) > 0.3;
}

struct Piece {
    std::int64_t column, layer;
    double volume;
};

/// Of what does not fly, by sorting the pieces of each column.
template <class Real>
double resting_volume(Simulation<Real, 3>& sim, const Comm& comm) {
    const Scene& scene = sim.scene();
    const double a = scene.hazard.cell;
    const Ground& ground = *scene.structures[0].ground;
    const int parts = std::max(2, static_cast<int>(std::ceil(2 * a / ground.spacing)));
    const Cut cut_x(scene, 0), cut_y(scene, 1);
    const auto ends = [&](std::int64_t i, std::int64_t j) {
        const double along_x = cut_x.side(i, a), along_y = cut_y.side(j, a);
        std::pair<double, double> low_high{1e9, -1e9};
        for (int n = 0; n <= parts; ++n)
            for (int m = 0; m <= parts; ++m) {
                const Vec<double, 3> at{{a * double(i) + along_x * n / parts, a * double(j) + along_y * m / parts, 0}};
                const double height = ground_at<3>(ground.table.data(), at).height;
                low_high = {std::min(low_high.first, height), std::max(low_high.second, height)};
            }
        return low_high;
    };
    const ParticleView<Real, 3> p = sim.patch().particles.view();
    std::vector<Piece> mine;
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 3>& x) {
        const auto i = std::min(cut_x.columns - 1, static_cast<std::int64_t>(x[0] / a));
        const auto j = std::min(cut_y.columns - 1, static_cast<std::int64_t>(x[1] / a));
        const auto layer = static_cast<std::int64_t>(std::floor((x[2] - ends(i, j).first) / scene.cell));
        mine.push_back({1000 * j + i, std::max<std::int64_t>(0, layer), double(p.volume[s])});
    });
    std::vector<Piece> all = comm.all_gather(mine);
    std::sort(all.begin(), all.end(), [](const Piece& one, const Piece& other) {
        return std::pair(one.column, one.layer) < std::pair(other.column, other.layer);
    });
    double sum = 0;
    std::int64_t column = -1, reached = 0;
    for (const Piece& piece : all) {
        if (piece.column != column) {
            column = piece.column;
            const auto [low, high] = ends(column % 1000, column / 1000);
            reached = static_cast<std::int64_t>(std::floor((high - low) / scene.cell)) + 1;
        }
        if (piece.layer > reached + 2) continue;
        reached = std::max(reached, piece.layer);
        sum += piece.volume;
    }
    return sum;
}

template <class Real>
void maps_hold_all() {
    const Comm comm(MPI_COMM_WORLD);
    const Scene scene = leaving();
    Simulation<Real, 3> sim(scene, comm);
    sim.seed();
    HazardMaps maps(scene, comm);
    double worst = 0, lost = 0, released = 0;
    int nobody = 0;  // flies
    while (sim.clock().time < 0.15) {
        sim.step(), sim.balance();
        sim.bin();
        maps.sample(sim);
        const double depth = volume_in(maps, scene), resting = resting_volume(sim, comm);
        worst = std::max(worst, std::fabs(depth / resting - 1));
        if (flies(sim, comm)) continue;
        CHECK(resting == doctest::Approx(volume_of(sim, comm)).epsilon(1e-12));
        ++nobody;
    }
    sim.conclude();
    for (const BodySpec& body : scene.bodies) released += 1500 * measure_of(body, 3);
    lost = sum_of(sim, sim.budget().lost_mass);
    CAPTURE(worst);
    CHECK(worst <= 1e-6);
    CHECK(nobody > 20);
    CHECK(lost > 0.1 * released);
    CHECK(totals_of(sim).mass + lost == doctest::Approx(released).epsilon(std::is_same_v<Real, float> ? 1e-6 : 1e-12));
}

template <class Real>
void lands() {
    const Comm comm(MPI_COMM_WORLD);
    Scene scene = leaving();
    scene.gravity = {0, 0, -40};
    scene.bodies = {test::small_valley(InterfaceLaw::voellmy, false).bodies[0]};
    scene.bodies[0].min = {0.4, 0.3, 1.3}, scene.bodies[0].max = {0.8, 0.7, 1.4};
    scene.bodies[0].velocity = {};
    Simulation<Real, 3> sim(scene, comm);
    sim.seed();
    HazardMaps maps(scene, comm);
    sim.bin();
    maps.sample(sim);
    CHECK(flies(sim, comm));
    CHECK(volume_in(maps, scene) == 0);
    while (flies(sim, comm) && sim.clock().time < 0.5) sim.step(), sim.balance();
    sim.bin();
    maps.sample(sim);
    CHECK(volume_in(maps, scene) == doctest::Approx(volume_of(sim, comm)).epsilon(1e-6));
    sim.conclude();
}

}  // namespace

TEST_CASE("what is over two empty layers flies") {
    CHECK(resting_layers(0b1111, 1) == 0b1111);
    CHECK(resting_layers(0b10111, 1) == 0b10111);
    CHECK(resting_layers(0b100111, 1) == 0b111);
    CHECK(resting_layers(0b1000001, 6) == 0b1000001);  // both may touch the ground
    CHECK(resting_layers(0b1000000001, 6) == 0b1);
    CHECK(resting_layers(0b100000, 2) == 0);
    CHECK(resting_layers(0b10000, 2) == 0b10000);
    CHECK(resting_layers(~Layers(0), 0) == ~Layers(0));
    CHECK(resting_layers(Layers(1) << 63, 63) == Layers(1) << 63);
    CHECK(resting_layers(0, 5) == 0);
}

TEST_CASE("a block in the air is no depth until it lands, and one on the ground is") {
    lands<double>();
    lands<float>();
}

TEST_CASE("thin layers and one particle on 45 degrees are all depth, with map cells of any size") {
    const Comm comm(MPI_COMM_WORLD);
    for (double thickness : {0.1, 0.15, 0.3})
        for (double side : {0.03, 0.1, 0.55}) {
            CAPTURE(thickness);
            CAPTURE(side);
            Scene scene = leaving();
            scene.structures[0].ground = std::make_shared<Ground>(
                test::ground_of({-0.55, -0.55}, 26, 0.17, false, [](double x, double) { return 1.5 - x; }));
            scene.bodies = {late(scene, 0, 0.2)};
            scene.bodies[0].thickness = thickness;
            if (side == 0.1) scene.bodies[0].points = {{0.5, 0.5}, {0.54, 0.5}, {0.54, 0.54}, {0.5, 0.54}};
            scene.hazard.cell = side;
            Simulation<double, 3> sim(scene, comm);
            sim.seed();
            sim.bin();
            HazardMaps maps(scene, comm);
            maps.sample(sim);
            CHECK(volume_of(sim, comm) > 0);
            CHECK(volume_in(maps, scene) == doctest::Approx(volume_of(sim, comm)).epsilon(1e-6));
            sim.conclude();
        }
}

TEST_CASE("a map cell that sticks out of the domain has the depth that lies there") {
    const Comm comm(MPI_COMM_WORLD);
    for (double side : {0.35, 0.3, 0.23, 0.15, 0.2}) {
        CAPTURE(side);
        Scene scene = leaving();
        scene.structures[0].ground = std::make_shared<Ground>(
            test::ground_of({-0.55, -0.55}, 26, 0.17, false, [](double, double) { return 0.5; }));
        scene.bodies = {late(scene, 0, 0)};
        scene.bodies[0].points = {{0.6, 0.2}, {1.6, 0.2}, {1.6, 1.2}, {0.6, 1.2}};
        scene.hazard.cell = side;
        Simulation<double, 3> sim(scene, comm);
        sim.seed();
        sim.bin();
        HazardMaps maps(scene, comm);
        maps.sample(sim);
        sim.conclude();
        const std::vector<double> all = stored_in(maps);
        const Cut x(scene, 0), y(scene, 1);
        int edge = 0;
        for (std::size_t at = 1; at < all.size(); at += 7) {
            const std::int64_t k = std::llround(all[at]), i = k % x.columns, j = k / x.columns;
            if ((i + 1 < x.columns || double(j) * side < 0.45) && (j + 1 < y.columns || double(i) * side < 0.85))
                continue;
            CAPTURE(i);
            CAPTURE(j);
            CHECK(all[at + 1] > 0.15);
            CHECK(all[at + 1] < 0.27);
            if (i + 1 == x.columns && j + 1 == y.columns && side != 0.23) CHECK(all[at + 1] == doctest::Approx(0.2));
            ++edge;
        }
        CHECK(edge > 2);
    }
}

TEST_CASE("maps have the volume of the particles in 1e-6, with releases that come late and soil that leaves") {
    maps_hold_all<double>();
    maps_hold_all<float>();
}
