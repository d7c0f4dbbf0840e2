#include <doctest/doctest.h>

#include <cmath>

#include "core/structures/structure_set.hpp"
#include "structure_scene.hpp"

using namespace moraine;

namespace {

constexpr double pi = 3.14159265358979323846;

StructureSpec free_spec(StructureShape shape, double mass = 3) {
    StructureSpec s;
    s.shape = shape;
    s.center = {0.3, -0.2, 0.1};
    s.radius = 0.4;
    s.from = {-0.5, 0.1, -0.2};
    s.to = {0.6, 0.5, 0.4};
    s.min = {-0.5, -0.3, -0.6};
    s.max = {0.7, 0.4, 0.5};
    s.motion.kind = StructureMotion::free;
    s.motion.turns = true;
    s.motion.mass = mass;
    return s;
}

/// The corners of a box, turned by an angle about a point that is not its middle.
std::vector<std::array<double, 2>> turned_box(double a, double b, double angle) {
    std::vector<std::array<double, 2>> points;
    for (const auto& [x, y] : {std::pair(-a, -b), std::pair(a, -b), std::pair(a, b), std::pair(-a, b)})
        points.push_back(
            {1.3 + x * std::cos(angle) - y * std::sin(angle), 0.7 + x * std::sin(angle) + y * std::cos(angle)});
    return points;
}

template <int Dim>
void go(StructureSet<Dim>& set, double& t, double dt, const std::array<double, Dim>& gravity = {},
        const StructureSums<Dim>& felt = {}, const TurningSums<Dim>& turning = {}) {
    set.begin_step(t, dt, gravity, std::array{felt}, Quantum::for_largest(1e3), std::array{turning});
    t += dt;
    set.end_step(t, dt);
}

}  // namespace

TEST_CASE("inertia is that of the shape, of one density") {
    const double m = 3, r = 0.4, h = 0.5 * std::sqrt(1.1 * 1.1 + 0.4 * 0.4 + 0.6 * 0.6);
    CHECK(rigid_body<2>(free_spec(StructureShape::sphere)).about[0] == doctest::Approx(m * r * r / 2));
    CHECK(rigid_body<2>(free_spec(StructureShape::box)).about[0] == doctest::Approx(m * (1.44 + 0.49) / 12));
    CHECK(rigid_body<3>(free_spec(StructureShape::sphere)).about[2] == doctest::Approx(0.4 * m * r * r));
    const RigidBody<3> box = rigid_body<3>(free_spec(StructureShape::box));
    CHECK(box.about[0] == doctest::Approx(m * (0.49 + 1.21) / 12));
    CHECK(box.about[1] == doctest::Approx(m * (1.44 + 1.21) / 12));
    const StructureSpec rod = free_spec(StructureShape::cylinder);
    const Mat<double, 3> all = rigid_body<3>(rod).inertia({});
    const Vec<double, 3> axis = (0.5 / h) * (vec_of<3>(rod.to) - vec_of<3>(rod.from));
    CHECK(dot(axis, all * axis) == doctest::Approx(m * r * r / 2));
    CHECK(all(0, 0) + all(1, 1) + all(2, 2) == doctest::Approx(m * r * r / 2 + 2 * m * (r * r / 4 + h * h / 3)));
    // a capsule is a ball where its ends meet, and a needle where it is thin
    StructureSpec capsule = free_spec(StructureShape::capsule);
    capsule.to = {-0.5, 0.1, -0.2 + 1e-9};
    CHECK(rigid_body<3>(capsule).about[0] == doctest::Approx(0.4 * m * r * r));
    CHECK(rigid_body<2>(free_spec(StructureShape::capsule)).about[0] > m * r * r / 2);
    capsule = free_spec(StructureShape::capsule);
    capsule.radius = 1e-6;
    CHECK(rigid_body<3>(capsule).about[0] == doctest::Approx(m * h * h / 3).epsilon(1e-4));
}

TEST_CASE("a prism of a turned rectangle has the axes, the centre and the inertia of the box") {
    StructureSpec prism = free_spec(StructureShape::polygon);
    for (double angle : {0.0, 0.3, 1.2, 2.5}) {
        CAPTURE(angle);
        prism.points = turned_box(0.6, 0.35, angle);
        const RigidBody<3> body = rigid_body<3>(prism);
        CHECK(body.about[0] == doctest::Approx(3 * (0.49 + 1.21) / 12));
        CHECK(body.about[1] == doctest::Approx(3 * (1.44 + 1.21) / 12));
        CHECK(body.about[2] == doctest::Approx(3 * (1.44 + 0.49) / 12));
        CHECK(rigid_body<2>(prism).about[0] == doctest::Approx(body.about[2]));
        const Vec<double, 3> centre = centre_of_mass<3>(prism);
        CHECK(centre[0] == doctest::Approx(1.3));
        CHECK(centre[1] == doctest::Approx(0.7));
        CHECK(centre[2] == doctest::Approx(-0.05));
        const Vec<double, 3> first{{std::cos(angle), std::sin(angle), 0}};
        CHECK(dot(first, body.inertia({}) * first) == doctest::Approx(body.about[0]));
        CHECK(volume_of(prism, 3) == doctest::Approx(1.2 * 0.7 * 1.1));
    }
}

TEST_CASE("a free top about its middle axis keeps its energy and the size of its angular momentum, and flips") {
    RigidBody<3> top;
    top.mass = 1;
    top.about = {{1, 2, 3}};
    Rotation<3> turned;
    const Vec<double, 3> w{{1e-3, 1, 1e-3}}, L = top.inertia(turned) * w;
    double energy = 0, length = 0, sign = 1;
    int flips = 0;
    const double dt = 0.02;
    for (int k = 0; k < int(2000 * pi / dt); ++k) {
        turned = normalised(rotation_by(vector_of(top.turn(turned, L, dt))) * turned);
        const Vec<double, 3> own = turned_back(matrix_of(turned), L);
        double e = 0;
        for (int a = 0; a < 3; ++a) e += own[a] * own[a] / top.about[a];
        energy = std::fmax(energy, std::fabs(e / dot(w, L) - 1));
        length = std::fmax(length, std::fabs(magnitude(own) / magnitude(L) - 1));
        if (own[1] * sign < -1) ++flips, sign = -sign;
    }
    CHECK(energy < 1e-9);  // in 1000 turns of 314 steps
    CHECK(length < 1e-13);
    CHECK(flips == 228);
}

TEST_CASE("the axis of a symmetric free top goes round at (I3 - I1) / I1 of its spin") {
    StructureSpec spec = free_spec(StructureShape::sphere, 1);
    spec.motion.inertia = {2, 2, 3};
    spec.motion.angular_velocity = {0.1, 0, 4};
    const Scene scene = scene_with(3, spec);
    StructureSet<3> set(scene);
    double t = 0, angle = 0, last = 0;
    const Vec<double, 3> L = set.state(0).carried_spin;
    while (t < 5) {
        go<3>(set, t, 0.01);
        const Vec<double, 3> own = turned_back(matrix_of(set.state(0).turned), L);
        const double now = std::atan2(own[1], own[0]);
        angle += std::remainder(now - last, 2 * pi), last = now;
    }
    CHECK(angle / t == doctest::Approx((3 - 2) / 2.0 * 4).epsilon(1e-6));
    for (int a = 0; a < 3; ++a) CHECK(set.state(0).carried_spin[a] == L[a]);
    for (int a = 0; a < 3; ++a) CHECK(set.state(0).displacement[a] == 0);
}

TEST_CASE("a structure that falls and turns does both as if alone") {
    StructureSpec spec = free_spec(StructureShape::box, 2);
    spec.motion.velocity = {1, 2, 0};
    spec.motion.angular_velocity = {3};
    spec.motion.force = {4, 0, 0};
    Scene scene = scene_with(2, spec);
    StructureSet<2> set(scene);
    double t = 0;
    for (int k = 0; k < 1000; ++k) go<2>(set, t, 0.001, {0, -10});
    CHECK(set.state(0).turned.e[0] == doctest::Approx(3));
    CHECK(set.state(0).displacement[0] == doctest::Approx(1 + 1).epsilon(2e-3));
    CHECK(set.state(0).displacement[1] == doctest::Approx(2 - 5).epsilon(2e-3));
    // where its surface is, and how fast
    set.place();
    const ContactField<2> f = set.field();
    const Structure<2>& s = f.structure[0];
    const double c = std::cos(3.0), n = std::sin(3.0);
    const Vec<double, 2> end = s.at - (-1.0) * Vec<double, 2>{{0.6 * c, 0.6 * n}};
    const Surface<2> at = surface(s, f.corners, end);
    CHECK(std::fabs(at.distance) < 1e-12);
    CHECK(at.normal[0] == doctest::Approx(c));
    CHECK(at.normal[1] == doctest::Approx(n));
    CHECK(velocity_at(s, end)[0] == doctest::Approx(s.velocity[0] - 3 * 0.6 * n));
    CHECK(velocity_at(s, end)[1] == doctest::Approx(s.velocity[1] + 3 * 0.6 * c));
}

TEST_CASE("moments turn a structure, and those that follow it do not push it too far") {
    StructureSpec spec = free_spec(StructureShape::box, 2);
    spec.motion.inertia = {5};
    const Scene scene = scene_with(2, spec);
    StructureSet<2> set(scene);
    const Quantum quantum = Quantum::for_largest(1e3);
    StructureSums<2> felt;
    TurningSums<2> turning;
    // a node of 7 kg below the corner at (0.6, -0.35), which pressed by 3 N s
    felt.sum[1] = quantum.of(3);
    felt.sum[2] = quantum.of(0.6 * 3);
    add_following<2>({7, 0, {{0, 1}}, {{0.6, -0.35}}}, quantum, turning);
    double t = 0;
    go<2>(set, t, 0.1, {}, felt, turning);
    CHECK(set.state(0).carried[1] == doctest::Approx(1.5));
    CHECK(set.state(0).carried_spin[0] == doctest::Approx(1.8));
    // (M + K) x* = p + J': what the node sees is slower than by twice the impulse, by its own mass
    const double v = set.state(0).velocity[1], w = set.state(0).spin[0];
    CHECK(2 * v + 7 * (v + 0.6 * w) == doctest::Approx(6));
    CHECK(5 * w + 0.6 * 7 * (v + 0.6 * w) == doctest::Approx(3.6));
    CHECK(set.state(0).velocity[0] == 0);
}

TEST_CASE("a prescribed turn follows the same function of time as the way") {
    StructureSpec spec = free_spec(StructureShape::box);
    spec.motion = {};
    spec.motion.kind = StructureMotion::velocity;
    spec.motion.ramp = 0.4;
    spec.motion.angular_velocity = {0, 3, 4};
    const Scene scene = scene_with(3, spec);
    StructureSet<3> set(scene);
    double t = 0;
    for (int k = 0; k < 100; ++k) go<3>(set, t, 0.01);
    const Rotation<3> exact = rotation_by((t - 0.2) * Vec<double, 3>{{0, 3, 4}});
    for (int q = 0; q < 4; ++q) CHECK(set.state(0).turned.e[q] == doctest::Approx(exact.e[q]));
    CHECK(set.state(0).spin[2] == doctest::Approx(4));
    StructureSet<3> restarted(scene);
    restarted.states() = set.states();
    set.place(), restarted.place();
    for (int q = 0; q < 9; ++q)
        CHECK((&restarted.field().structure[0].turn.e[0][0])[q] == (&set.field().structure[0].turn.e[0][0])[q]);
}

TEST_CASE("rotations add up, and a vector comes back from each") {
    const Vec<double, 3> r{{0.3, -1.1, 0.7}};
    const Vec<double, 3> back = vector_of(rotation_by(r));
    for (int a = 0; a < 3; ++a) CHECK(back[a] == doctest::Approx(r[a]));
    CHECK(magnitude(vector_of(rotation_by(Vec<double, 3>{{0, 0, 0}}))) == 0);
    const Rotation<3> first = rotation_by(r), then = rotation_by(Vec<double, 3>{{0.2, 0.5, -2}});
    const Mat<double, 3> both = matrix_of(then * first), product = matrix_of(then) * matrix_of(first);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) CHECK(both(i, j) == doctest::Approx(product(i, j)));
    const Vec<double, 3> x{{1, 0, 0}}, up = matrix_of(rotation_by(Vec<double, 3>{{0, 0, pi / 2}})) * x;
    CHECK(up[1] == doctest::Approx(1));
}
