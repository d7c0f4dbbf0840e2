#include <doctest/doctest.h>

#include <cstdio>
#include <map>
#include <string>

#include "sample_scenes.hpp"
#include "simulation/diagnostics.hpp"

using namespace moraine;

// What happens at the ends: of the domain, and of what a time step may be.

namespace {

using Shape = moraine::Shape;
constexpr Shape every_shape[] = {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::quadratic, Shape::cubic};

/// A block that slides up along the smooth wall x = max, its last column of particles exactly on the wall.
Scene sliding() {
    Scene s;
    s.transfer = Transfer::flip;
    s.dimensions = 2;
    s.max = {4, 8, 0};
    s.cell = 0.5;
    s.walls[0][1].kind = WallKind::free_slip;
    s.materials = {test::material("linear-elastic", 1000, {{"young", 1e5}, {"poisson", 0.3}})};
    s.bodies = {test::box({2, 1, 0}, {3.75, 3, 0}, 0), test::box({3.75, 1, 0}, {4.25, 3, 0}, 0)};
    s.bodies[1].particles_per_cell = {1, 2, 2};
    for (BodySpec& body : s.bodies) {
        body.seeding = Seeding::lattice;
        body.velocity = {0, 1, 0};
    }
    return s;
}

/// Largest stress, difference of the velocity from (0, 1), and distance of the last column from x = 4.
template <class Real>
double disturbance(const Scene& scene) {
    const Comm comm(MPI_COMM_WORLD);
    Simulation<Real, 2> sim(scene, comm);
    sim.seed();
    for (int n = 0; n < 100; ++n) sim.step();
    sim.conclude();
    CHECK(comm.sum(sim.patch().count()) == 64);
    const ParticleView<Real, 2> p = sim.patch().particles.view();
    double worst = 0, right = 0;
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 2>& x) {
        for (int k = 0; k < 4; ++k) worst = std::max(worst, std::fabs(double(p.stress[s][k])) / 1e5);
        worst = std::max({worst, std::fabs(double(p.velocity[s][0])), std::fabs(double(p.velocity[s][1]) - 1)});
        right = std::max(right, x[0]);
    });
    return std::max(worst, std::fabs(comm.max(right) - 4));
}

}  // namespace

TEST_CASE("particles exactly on the upper face slide along it undisturbed, for every shape") {
    for (Shape shape : every_shape) {
        CAPTURE(int(shape));
        Scene scene = sliding();
        scene.shape = shape;
        CHECK(disturbance<double>(scene) < 1e-12);
        CHECK(disturbance<float>(scene) < 1e-4);
    }
}

namespace {

/// The place in the words of a PhysicsError [m].
std::array<double, 2> place_said(const std::string& message) {
    const std::size_t at = message.find("at (");
    REQUIRE(at != std::string::npos);
    std::array<double, 2> place{};
    REQUIRE(std::sscanf(message.c_str() + at, "at (%lf, %lf) m", &place[0], &place[1]) == 2);
    return place;
}

/// Runs until the physics goes wrong. Largest distance along an axis between the place that is said and the faulty
/// particle's place in the last state [m].
double place_error(const Scene& scene, const std::string& what) {
    const Comm comm(MPI_COMM_WORLD);
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    std::map<std::uint64_t, std::array<double, 2>> places;
    const auto look = [&] {
        sim.bin();
        places.clear();
        const ParticleView<double, 2> p = sim.patch().particles.view();
        each_particle(sim, [&](std::uint32_t s, const std::array<double, 2>& x) { places[p.id[s]] = x; });
    };
    try {
        for (int n = 0; n < 2000; ++n) {
            look();
            sim.step();
            sim.balance();
        }
    } catch (const PhysicsError& e) {
        const std::string message = e.what();
        CAPTURE(message);
        CHECK(message.find(what) != std::string::npos);
        const auto found = places.find(std::stoull(message.substr(message.find("particle") + 9)));
        double error = 0;
        if (found != places.end())
            for (std::size_t a = 0; a < 2; ++a)
                error = std::max(error, std::fabs(place_said(message)[a] - found->second[a]));
        const std::int64_t seen = found != places.end();
        CHECK(comm.sum(seen) == 1);
        return comm.max(error);
    }
    FAIL("nothing went wrong");
    return 0;
}

}  // namespace

TEST_CASE("a particle that left the closed domain is said to be where the last state has it, for every shape") {
    for (Shape shape : every_shape) {
        CAPTURE(int(shape));
        Scene scene = test::slurry();
        scene.shape = shape;
        scene.walls[0][1].kind = WallKind::none;
        scene.cfl = 0.2;
        CHECK(place_error(scene, "left the closed domain") < 1e-5);
    }
}

TEST_CASE("a particle that is turned inside out is said to be where it is, whatever the order of the rounds") {
    for (const auto& [scheme, speed] : {std::pair(StressUpdate::usl, 12.0), std::pair(StressUpdate::usf, 14.0),
                                        std::pair(StressUpdate::musl, 12.0)}) {
        CAPTURE(int(scheme));
        Scene scene = test::slurry();
        scene.stress_update = scheme;
        scene.shape = Shape::linear;
        scene.gravity = {};
        scene.walls = {};
        scene.materials = {test::material("neo-hookean", 1500, {{"young", 25}, {"poisson", 0.3}})};
        scene.bodies[0].velocity = {};
        scene.bodies[0].geostatic = false;
        scene.bodies[0].wave = {{speed, 0, 0}, 0, 2.55, 0.4};  // of 4 cells: hats leave less than a cell a step of it
        scene.dt = 0.01;
        CHECK(place_error(scene, "inside out") < scene.cell);  // USF sees it before it moves
    }
}

TEST_CASE("a step that has become absurdly small ends the run") {
    const Comm comm(MPI_COMM_WORLD);
    Scene scene = test::slurry();
    scene.end = 1;
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    if (sim.patch().count() > 0) sim.patch().particles.view().velocity[sim.patch().list().slot[0]][0] = 1e14;
    sim.refresh_signal();
    CHECK_THROWS_WITH_AS(sim.step(), doctest::Contains("step 0: dt fell to 5e-16 s at t = 0 s"), PhysicsError);
}

TEST_CASE("when the last particle has left, time goes on by the step that it had") {
    const Comm comm(MPI_COMM_WORLD);
    Scene scene = sliding();
    scene.walls[1][1].kind = WallKind::open;
    scene.end = 100;
    for (BodySpec& body : scene.bodies) body.velocity = {0, 5, 0};
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    for (int n = 0; n < 400; ++n) sim.step(), sim.balance();
    sim.conclude();
    CHECK(comm.sum(sim.patch().count()) == 0);
    CHECK(comm.sum(sim.budget().lost_count) == 64);
    CHECK(std::isfinite(sim.clock().time));
    CHECK(sim.clock().time < 10);
}
