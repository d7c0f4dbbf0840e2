// Structures that meet one another and walls, against closed forms: no soil is near.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "core/sample_ground.hpp"
#include "core/structures/structure_set.hpp"

using namespace moraine;

namespace {

constexpr double pi = 3.14159265358979323846, g = 9.81;

/// Walls all around; what is tested stands on y = 0.
Scene closed_scene(int dimensions, const Triple& origin = {}) {
    Scene scene;
    scene.dimensions = dimensions;
    scene.cell = 0.1;
    for (std::size_t a = 0; a < 3; ++a) scene.min[a] = origin[a] - (a == 1 ? 0 : 50), scene.max[a] = origin[a] + 50;
    for (auto& axis : scene.walls)
        for (WallSpec& wall : axis) wall.kind = WallKind::no_slip;
    scene.materials.resize(1);
    scene.materials[0].density = 1000;
    scene.bodies.resize(1);
    return scene;
}

StructureSpec free_one(StructureShape shape, double friction, double restitution = 0) {
    StructureSpec s;
    s.name = "it";
    s.shape = shape;
    s.motion.kind = StructureMotion::free;
    s.motion.turns = true;
    s.motion.mass = 10;
    s.motion.collision = CollisionSpec{friction, restitution};
    return s;
}
StructureSpec ball(const Triple& centre, double radius, double friction, double restitution) {
    StructureSpec s = free_one(StructureShape::sphere, friction, restitution);
    s.center = centre, s.radius = radius;
    return s;
}
StructureSpec box(const Triple& min, const Triple& max, double friction) {
    StructureSpec s = free_one(StructureShape::box, friction);
    s.min = min, s.max = max;
    return s;
}
/// The same as a polygon, in 3-D a prism.
StructureSpec prism(const Triple& min, const Triple& max, double friction) {
    StructureSpec s = free_one(StructureShape::polygon, friction);
    s.min = min, s.max = max;
    s.points = {{min[0], min[1]}, {max[0], min[1]}, {max[0], max[1]}, {min[0], max[1]}};
    return s;
}

template <int Dim>
struct Drive {
    StructureSet<Dim> set;
    double dt, t = 0;

    Drive(const Scene& scene, double step) : set(scene), dt(step) {}
    const StructureState<Dim>& operator[](std::size_t k) const { return set.state(k); }
    void step(const std::array<double, Dim>& gravity) {
        const std::vector<StructureSums<Dim>> felt(set.size());
        const std::vector<TurningSums<Dim>> turning(set.size());
        set.begin_step(t, dt, gravity, felt, Quantum::for_largest(1e3), turning);
        t += dt;
        set.end_step(t, dt);
    }
};

/// Of a gravity that leans towards x.
template <int Dim>
std::array<double, Dim> leaning(double angle) {
    std::array<double, Dim> of{};
    of[0] = g * std::sin(angle), of[1] = -g * std::cos(angle);
    return of;
}

/// Over its height, how far a ball that fell from there comes up again.
template <int Dim>
double bounce(double restitution, double dt) {
    Scene scene = closed_scene(Dim);
    scene.structures = {ball({0, 1.3, 0}, 0.3, 0.5, restitution)};
    Drive<Dim> drive(scene, dt);
    double lowest = 0, top = -1;
    while (drive.t < 0.45 + 0.45 * restitution) {  // it falls for 0.4515 s
        drive.step(leaning<Dim>(0));
        const double y = drive[0].displacement[1];
        lowest = std::fmin(lowest, y);
        if (drive[0].velocity[1] > 0 || top > -1) top = std::fmax(top, y);
    }
    CHECK(lowest > -1 - 1e-9);
    return 1 + top;
}

/// Acceleration down a slope over g, after a second.
template <int Dim>
double down_a_slope(StructureSpec one, double angle) {
    Scene scene = closed_scene(Dim);
    scene.structures = {one};
    Drive<Dim> drive(scene, 1e-3);
    while (drive.t < 1) drive.step(leaning<Dim>(angle));
    return drive[0].velocity[0] / (drive.t * g);
}

double angle_of(const Rotation<2>& r) {
    return r.e[0];
}
double angle_of(const Rotation<3>& r) {
    return vector_of(r)[2];
}

}  // namespace

TEST_CASE("a ball that falls on a wall comes up to the square of its restitution") {
    for (double e : {0.0, 0.5, 0.9, 1.0}) {
        const double coarse = bounce<3>(e, 1e-3), fine = bounce<2>(e, 1e-4);
        MESSAGE(
            fmt::format("restitution {}: up to {:.5f} at 1 ms, {:.5f} at 0.1 ms of {:.5f}", e, coarse, fine, e * e));
        CHECK(std::fabs(coarse - e * e) < 5e-3);
        CHECK(std::fabs(fine - e * e) < 5e-4);
    }
}

TEST_CASE("two balls keep momentum and angular momentum, and part by their restitution") {
    Scene scene = closed_scene(3);
    scene.structures = {ball({-0.5, 5, 0}, 0.3, 0.3, 0.6), ball({0.5, 5.2, 0.1}, 0.2, 0.4, 0.8)};
    scene.structures[0].motion.velocity = {2, 0.1, 0.3};
    scene.structures[1].motion.mass = 3;
    scene.structures[1].motion.angular_velocity = {3, -5, 20};
    Drive<3> drive(scene, 1e-3);
    const Vec<double, 3> at[2] = {{{-0.5, 5, 0}}, {{0.5, 5.2, 0.1}}};
    const double mass[2] = {10, 3};
    const auto momenta = [&](Vec<double, 3>& linear, Vec<double, 3>& angular) {
        linear = angular = zero_vec<double, 3>();
        for (int k = 0; k < 2; ++k) {
            const auto& s = drive[static_cast<std::size_t>(k)];
            const Vec<double, 3> p = mass[k] * s.carried;
            linear = linear - (-1.0) * p;
            angular = angular - (-1.0) * moment_of(at[k] - (-1.0) * s.displacement, p) - (-1.0) * s.carried_spin;
        }
    };
    Vec<double, 3> p0, L0, p1, L1;
    momenta(p0, L0);
    const auto apart = [&] {
        const Vec<double, 3> way = at[1] - at[0] - (-1.0) * (drive[1].displacement - drive[0].displacement);
        return dot((1 / magnitude(way)) * way, drive[1].velocity - drive[0].velocity);
    };
    double before = apart(), after = before;
    while (drive.t < 0.5 && after < 0) {
        before = after;
        drive.step({});
        after = apart();
    }
    momenta(p1, L1);
    MESSAGE(fmt::format("two balls: momentum {:.1e}, angular {:.1e}, restitution {:.5f}",
                        magnitude(p1 - p0) / magnitude(p0), magnitude(L1 - L0) / magnitude(L0), -after / before));
    CHECK(magnitude(p1 - p0) < 1e-14 * magnitude(p0));
    CHECK(magnitude(L1 - L0) < 1e-13 * magnitude(L0));
    CHECK(-after / before == doctest::Approx(0.6).epsilon(0.02));  // the normal turns by 0.6 degrees in that step
    CHECK(magnitude(drive[0].spin) > 0.1);
}

TEST_CASE("a box on a slope sticks up to the angle of its friction and slides beyond by what is left") {
    const double mu = 0.4, steep = std::atan(mu);
    const StructureSpec boxes[] = {box({-0.5, 0, -0.4}, {0.5, 0.3, 0.4}, mu),
                                   prism({-0.5, 0, -0.4}, {0.5, 0.3, 0.4}, mu)};
    for (const StructureSpec& one : boxes) {
        CHECK(std::fabs(down_a_slope<2>(one, 0.999 * steep)) < 1e-9);
        CHECK(std::fabs(down_a_slope<3>(one, 0.999 * steep)) < 1e-9);
        for (double angle : {1.001 * steep, 30 * pi / 180}) {
            const double exact = std::sin(angle) - mu * std::cos(angle);
            CHECK(down_a_slope<2>(one, angle) == doctest::Approx(exact).epsilon(1e-6));
            CHECK(down_a_slope<3>(one, angle) == doctest::Approx(exact).epsilon(1e-6));
        }
    }
}

TEST_CASE("what is round rolls down a slope as its inertia has it") {
    for (double degrees : {5.0, 20.0}) {
        const double angle = degrees * pi / 180;
        CHECK(down_a_slope<2>(ball({0, 0.3, 0}, 0.3, 0.5, 0), angle) ==
              doctest::Approx(2.0 / 3 * std::sin(angle)).epsilon(1e-6));
        CHECK(down_a_slope<3>(ball({0, 0.3, 0}, 0.3, 0.5, 0), angle) ==
              doctest::Approx(5.0 / 7 * std::sin(angle)).epsilon(1e-6));
    }
}

TEST_CASE("a block topples where its weight leaves its foot, and stands before") {
    const double diagonal = std::atan(0.5);
    const auto turned = [&](auto dim, double angle) {
        constexpr int Dim = decltype(dim)::value;
        Scene scene = closed_scene(Dim);
        scene.structures = {box({-0.2, 0, -0.2}, {0.2, 0.8, 0.2}, 2)};
        Drive<Dim> drive(scene, 1e-3);
        while (drive.t < 3) drive.step(leaning<Dim>(angle));
        return angle_of(drive[0].turned);
    };
    const std::integral_constant<int, 2> flat;
    const std::integral_constant<int, 3> solid;
    CHECK(std::fabs(turned(flat, 0.999 * diagonal)) < 1e-6);
    CHECK(std::fabs(turned(solid, 0.999 * diagonal)) < 1e-6);
    CHECK(turned(flat, 1.001 * diagonal) < -0.3);
    CHECK(turned(solid, 1.001 * diagonal) < -0.3);
}

TEST_CASE("a block rocks as Housner has it: how long it falls, and what is left after its blow") {
    // 1 x 4 m: p = 1.889 1/s, critical angle 14.04 degrees; let go at half of it
    const double alpha = std::atan(0.25), p = std::sqrt(3 * g / (4 * std::hypot(0.5, 2.0))), begin = alpha / 2;
    Scene scene = closed_scene(2);
    StructureSpec block = free_one(StructureShape::polygon, 5);
    const double c = std::cos(begin), s = std::sin(begin);
    for (const auto& [x, y] : {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(1.0, 4.0), std::pair(0.0, 4.0)})
        block.points.push_back({x * c - y * s, x * s + y * c});  // stands on its left corner
    scene.structures = {block};
    for (const double dt : {1e-3, 2.5e-4}) {
        Drive<2> drive(scene, dt);
        double before = 0, fell = 0, after = 0;
        while (drive.t < 1.2) {
            drive.step({0, -g});
            const double w = -drive[0].spin[0];
            if (fell == 0 && w < 0.95 * before) fell = drive.t;
            before = std::fmax(before, w);
            if (fell > 0 && drive.t < fell + 2.5 * dt) after = w;  // a blow takes two steps: to the wall, and at it
        }
        const double exact = std::acosh(1 / (1 - 0.5)) / p;  // small angles: 0.3 % here
        const double kept = after / before * after / before,
                     housner = std::pow(1 - 1.5 * std::pow(std::sin(alpha), 2), 2);
        MESSAGE(
            fmt::format("Housner's block, {} ms: falls for {:.4f} s of {:.4f}, keeps {:.4f} of its energy of {:.4f}",
                        1e3 * dt, fell, exact, kept, housner));
        CHECK(fell == doctest::Approx(exact).epsilon(0.01));
        CHECK(kept == doctest::Approx(housner).epsilon(0.02));
    }
}

namespace {

/// Ten boxes one on another, the upper ones narrower by `less` each.
template <int Dim>
Scene pile(bool of_prisms, double less, const Triple& origin = {}) {
    Scene scene = closed_scene(Dim, origin);
    for (int k = 0; k < 10; ++k) {
        const double half = 0.5 - less * k;
        Triple low{origin[0] - half, origin[1] + k, origin[2] - half},
            high{origin[0] + half, origin[1] + k + 1, origin[2] + half};
        scene.structures.push_back(of_prisms ? prism(low, high, 0.5) : box(low, high, 0.5));
        scene.structures.back().motion.mass = 1000;
    }
    return scene;
}

template <int Dim>
double drift(const Scene& scene, double dt) {
    Drive<Dim> drive(scene, dt);
    const auto start = std::chrono::steady_clock::now();
    int steps = 0;
    while (drive.t < 5) drive.step(leaning<Dim>(0)), ++steps;
    double most = 0;
    for (std::size_t k = 0; k < drive.set.size(); ++k)
        most = std::fmax(most, std::fmax(magnitude(drive[k].displacement), std::fabs(angle_of(drive[k].turned))));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    MESSAGE(fmt::format("a pile of ten in {}-D drifts by {:.1e} m or rad in 5 s; {:.3g} us a step", Dim, most,
                        1e6 * took.count() / steps));
    return most;
}

}  // namespace

TEST_CASE("a pile of ten boxes stands") {
    CHECK(drift<2>(pile<2>(false, 0), 1e-3) < 1e-8);
    CHECK(drift<2>(pile<2>(true, 0.02), 1e-3) < 1e-8);
    CHECK(drift<3>(pile<3>(true, 0.02), 2e-3) < 1e-5);
}

TEST_CASE("at map coordinates a pile stands as it does at the origin") {
    CHECK(drift<2>(pile<2>(false, 0, {6e5, 4.9e6, 0}), 1e-3) < 1e-5);
}

TEST_CASE("a run that goes on from what was stored has the same bits") {
    Scene scene = pile<2>(true, 0.03);
    scene.structures[4].motion.velocity = {3, 0, 0};
    Drive<2> whole(scene, 1e-3), first(scene, 1e-3), then(scene, 1e-3);
    for (int k = 0; k < 400; ++k) whole.step({0, -g});
    for (int k = 0; k < 200; ++k) first.step({0, -g});
    then.set.states() = first.set.states();
    const std::vector<double> stored = first.set.collisions()->stored();
    REQUIRE(!stored.empty());
    REQUIRE(then.set.collisions()->restore(stored));
    for (int k = 0; k < 200; ++k) then.step({0, -g});
    double way = 0;
    for (std::size_t k = 0; k < 10; ++k) {
        way = std::fmax(way, std::fabs(whole[k].displacement[0]));
        for (int a = 0; a < 2; ++a) CHECK(then[k].displacement[a] == whole[k].displacement[a]);
        CHECK(then[k].turned.e[0] == whole[k].turned.e[0]);
        CHECK(then[k].carried_spin[0] == whole[k].carried_spin[0]);
    }
    CHECK(way > 0.05);
    std::vector<double> bad = stored;
    bad.pop_back();
    CHECK(!then.set.collisions()->restore(bad));
    bad = stored, bad[3] = -1;
    CHECK(!then.set.collisions()->restore(bad));
}

TEST_CASE("what overlaps is parted without speed") {
    Scene scene = closed_scene(2);
    scene.structures = {box({-0.5, -0.01, 0}, {0.5, 0.99, 0}, 0.5)};
    Drive<2> drive(scene, 1e-3);
    double fastest = 0;
    while (drive.t < 0.2) drive.step({0, -g}), fastest = std::fmax(fastest, magnitude(drive[0].velocity));
    CHECK(drive[0].displacement[1] == doctest::Approx(0.01).epsilon(1e-3));
    CHECK(fastest < 1e-9);
}

namespace {

/// A prism along z, square and on its edge, from y on.
StructureSpec on_its_edge(double y) {
    StructureSpec s = free_one(StructureShape::polygon, 0.5);
    s.points = {{0, y}, {0.5, y + 0.5}, {0, y + 1}, {-0.5, y + 0.5}};
    s.min[2] = -2, s.max[2] = 2;
    return s;
}

}  // namespace

TEST_CASE("a prism across another is borne where their edges cross") {
    Scene scene = closed_scene(3);
    scene.structures = {on_its_edge(0), on_its_edge(1.02)};
    scene.structures[0].motion = {};
    Drive<3> drive(scene, 1e-3);
    drive.set.states()[1].turned = rotation_by(Vec<double, 3>{{0, pi / 2, 0}});
    while (drive.t < 0.3) drive.step({0, -g, 0});
    CHECK(drive[1].displacement[1] == doctest::Approx(-0.02).epsilon(1e-6));
    CHECK(magnitude(drive[1].spin) < 1e-6);
}

TEST_CASE("a ball meets a ridge at its periodic image, and slides off it") {
    Scene scene = closed_scene(3);
    scene.periodic[0] = true;
    for (WallSpec& wall : scene.walls[0]) wall.kind = WallKind::periodic;
    scene.structures = {on_its_edge(0), ball({100.1, 1.21, 0}, 0.2, 0.2, 0)};
    scene.structures[0].motion = {};
    Drive<3> drive(scene, 1e-3);
    while (drive.t < 0.5) drive.step({0, -g, 0});
    const Vec<double, 3> at = drive[1].displacement - (-1.0) * Vec<double, 3>{{0.1, 1.21, 0}};
    CHECK(at[0] > 0.3);
    CHECK((at[0] + at[1] - 1) / std::sqrt(2.0) == doctest::Approx(0.2).epsilon(1e-3));  // it lies on the side
}

TEST_CASE("on terrain a ball rolls and a box sticks or slides as on a slope") {
    const double angle = 15 * pi / 180, c = std::cos(angle), s = std::sin(angle);
    Scene scene = closed_scene(3);
    for (auto& axis : scene.walls)
        for (WallSpec& wall : axis) wall.kind = WallKind::open;
    StructureSpec terrain;
    terrain.name = "terrain";
    terrain.shape = StructureShape::ground;
    terrain.ground = std::make_shared<Ground>(
        test::ground_of({-20, -20}, 41, 1.0, false, [&](double x, double) { return -std::tan(angle) * x; }));
    scene.structures = {terrain, ball({0.5 * s, 0, 0.5 * c}, 0.5, 0.5, 0)};  // it touches at the origin
    Drive<3> rolls(scene, 1e-3);
    while (rolls.t < 1) rolls.step({0, 0, -g});
    CHECK(magnitude(rolls[1].velocity) / (rolls.t * g) == doctest::Approx(5.0 / 7 * s).epsilon(1e-4));
    CHECK(std::fabs(rolls[1].velocity[0] * s + rolls[1].velocity[2] * c) < 1e-6);
    scene.dimensions = 2;
    terrain.ground = std::make_shared<Ground>(
        test::ground_of({-20, -20}, 41, 1.0, true, [&](double x, double) { return -std::tan(angle) * x; }));
    for (const double friction : {1.01 * std::tan(angle), 0.1}) {
        StructureSpec flat = free_one(StructureShape::polygon, friction);
        flat.points = {{0, 0}, {c, -s}, {c + 0.4 * s, -s + 0.4 * c}, {0.4 * s, 0.4 * c}};
        scene.structures = {terrain, flat};
        Drive<2> slides(scene, 1e-3);
        while (slides.t < 1) slides.step({0, -g});
        const double exact = std::fmax(0.0, s - friction * c);
        CHECK(std::fabs(magnitude(slides[1].velocity) / (slides.t * g) - exact) < 1e-6);
    }
}

TEST_CASE("what a moving structure hits leaves it by its restitution") {
    Scene scene = closed_scene(2);
    scene.structures = {ball({0.5, 5, 0}, 0.3, 0, 0.5), box({-1, 4, 0}, {0, 6, 0}, 0)};
    MotionSpec& paddle = scene.structures[1].motion;
    paddle = {};
    paddle.kind = StructureMotion::velocity;
    paddle.velocity = {2, 0, 0};
    Drive<2> drive(scene, 1e-3);
    while (drive.t < 0.5) drive.step({});
    CHECK(drive[0].velocity[0] == doctest::Approx(2 * 1.5));
    CHECK(drive[0].velocity[1] == 0);
}

TEST_CASE("what does not meet goes through") {
    Scene scene = closed_scene(2);
    scene.structures = {ball({0, 1, 0}, 0.3, 0.5, 0), ball({0, 2, 0}, 0.3, 0.5, 0), ball({0, 3, 0}, 0.3, 0.5, 0)};
    scene.structures[1].motion.collision.reset();
    Drive<2> drive(scene, 1e-3);
    while (drive.t < 1.5) drive.step({0, -g});
    CHECK(drive[0].displacement[1] == doctest::Approx(-0.7));
    CHECK(drive[1].displacement[1] < -10);
    CHECK(drive[2].displacement[1] == doctest::Approx(-2.1));
}
