#include <doctest/doctest.h>

#include "core/structures/structure_set.hpp"

using namespace moraine;

namespace {

/// A plane through `point`, with what a field needs of a scene.
Scene plane_scene(moraine::Shape shape, const Triple& normal, const Triple& point = {0, 0, 0}) {
    Scene scene;
    scene.transfer = Transfer::flip;
    scene.dimensions = 2;
    scene.min = {-4, -4, 0};
    scene.max = {4, 4, 0};
    scene.cell = 0.5;
    scene.shape = shape;
    scene.materials.resize(1);
    scene.materials[0].density = 2;
    scene.bodies.resize(1);
    scene.structures.resize(1);
    scene.structures[0].normal = normal;
    scene.structures[0].point = point;
    return scene;
}

NodeGap told(double gap, double area = 1) {
    return {NodeGap::fixed(gap), NodeGap::fixed_area(area)};
}

/// The plane's field with sums to add to, and its one node.
struct Plane {
    Scene scene;
    StructureSet<2> set;
    StructureSums<2> sums;
    TurningSums<2> turning;
    ContactField<2> field;
    Quantum quantum = Quantum::for_largest(1e3);
    Structure<2> structure;

    explicit Plane(InterfaceLaw law)
        : scene(plane_scene(moraine::Shape::quadratic, {0, 1, 0})), set(scene), field(set.field()) {
        field.sums = &sums;
        structure = field.structure[0];
        structure.law = law;
        structure.friction = 0.5;
        structure.cap = 3;
        structure.velocity = {{1, 0}};
        field.structure = &structure;
    }

    /// Velocity of a node of mass 0.4 that stands `above` cells over the plane, which is at node 8; v is from outside.
    Vec<double, 2> touch(Vec<double, 2> v, int above = 0, const NodeGap& gap = told(0), ContactTime time = {0.1, 0.1}) {
        const int node[2] = {5, 8 + above};
        Vec<double, 2> given = zero_vec<double, 2>();
        touch_structures(
            field, node, 0.4, time, [&](int) { return gap; },
            [&](int k, const auto& values, const auto& following) {
                add_shared(field.sums[k].sum, quantum, values);
                if (structure.turns) add_following(following(), quantum, turning);
            },
            v, given);
        for (int a = 0; a < 2; ++a) CHECK(quantum.value(sums.sum[a]) == doctest::Approx(given[a]));
        return v;
    }
};

}  // namespace

TEST_CASE("a pressed node loses its velocity into the surface and nothing else on a smooth one") {
    Plane plane(InterfaceLaw::smooth);
    const Vec<double, 2> v = plane.touch({{3, -2}});
    CHECK(v[0] == 3);
    CHECK(v[1] == doctest::Approx(0).epsilon(1e-12));
    CHECK(plane.quantum.value(plane.sums.sum[1]) == doctest::Approx(-0.8));
}

TEST_CASE("a gap may close within the time in which particles move, and friction acts for the time of the substep") {
    const auto touch = [](InterfaceLaw law, Vec<double, 2> v, double gap, double dt) {
        return Plane(law).touch(v, 0, told(gap), {dt, 0.1});
    };
    const double approach = touch(InterfaceLaw::smooth, {{3, -2}}, 0.1, 0.1)[1];
    CHECK(approach < 0);
    CHECK(touch(InterfaceLaw::smooth, {{3, -2}}, 0.1, 0.01)[1] == approach);
    const double whole = 3 - touch(InterfaceLaw::undrained, {{3, 0}}, 0, 0.1)[0];
    CHECK(whole > 0);
    CHECK(3 - touch(InterfaceLaw::undrained, {{3, 0}}, 0, 0.01)[0] == doctest::Approx(0.1 * whole));
}

TEST_CASE("a node that leaves the structure, or whose soil is not there, is free") {
    Plane plane(InterfaceLaw::rough);
    CHECK(plane.touch({{3, 2}})[1] == 2);
    CHECK(plane.touch({{3, -2}}, 0, told(0.5))[0] == 3);
    CHECK(plane.touch({{3, -2}}, 0, told(0.5))[1] == -2);
    CHECK(plane.touch({{3, -2}}, 0, NodeGap{})[1] == -2);
    CHECK(plane.touch({{3, -2}}, 1)[1] == -2);
    CHECK(plane.touch({{3, -2}}, -1, told(-0.3))[1] == doctest::Approx(0));
}

TEST_CASE("a node is held wholly up to 0.5 cells outside the surface, and not at all from 0.6 on") {
    const auto left = [](double below, double gap) {
        Plane plane(InterfaceLaw::smooth);
        plane.structure.at[1] += (1 - below) * 0.5;  // node 9 is this many cells over it
        return plane.touch({{3, -2}}, 1, told(gap))[1];
    };
    CHECK(left(0.2, 0) == doctest::Approx(0).epsilon(1e-12));
    CHECK(left(0.45, 0) == doctest::Approx(0).epsilon(1e-12));
    CHECK(left(0.55, 0) == doctest::Approx(-1));
    CHECK(left(0.65, 0) == -2);
    CHECK(left(0.65, -0.5) == -2);  // wherever its soil is
}

TEST_CASE("a node comes nearer by its gap in a step and no more, and soil that is inside is not pushed out") {
    const auto left = [](double gap) { return Plane(InterfaceLaw::smooth).touch({{3, -2}}, 0, told(gap))[1]; };
    CHECK(left(0.1) == doctest::Approx(-0.5));  // 0.05 m in 0.1 s
    CHECK(left(0.3) == doctest::Approx(-1.5));
    CHECK(left(0.5) == -2);
    CHECK(left(0) == doctest::Approx(0).epsilon(1e-12));
    CHECK(left(-0.4) == doctest::Approx(0).epsilon(1e-12));
}

TEST_CASE("Coulomb friction takes at most mu times the normal impulse, and no more than the slip") {
    CHECK(Plane(InterfaceLaw::coulomb).touch({{3, -2}})[0] == doctest::Approx(2));
    CHECK(Plane(InterfaceLaw::coulomb).touch({{1.5, -2}})[0] == doctest::Approx(1));
    CHECK(Plane(InterfaceLaw::coulomb).touch({{-3, -2}})[0] == doctest::Approx(-2));
}

TEST_CASE("a rough surface holds the node; an undrained one takes at most its strength times the area") {
    CHECK(Plane(InterfaceLaw::rough).touch({{3, -2}})[0] == doctest::Approx(1));
    const double most = 3 * 0.5 * 0.1 / 0.4;  // cap area dt / mass
    CHECK(Plane(InterfaceLaw::undrained).touch({{3, -2}})[0] == doctest::Approx(3 - most));
    CHECK(Plane(InterfaceLaw::undrained).touch({{3, -200}})[0] == doctest::Approx(3 - most));
    CHECK(Plane(InterfaceLaw::undrained).touch({{1.1, -2}})[0] == doctest::Approx(1));
    CHECK(Plane(InterfaceLaw::undrained).touch({{3, 2}})[0] == doctest::Approx(3 - most));
    CHECK(Plane(InterfaceLaw::undrained).touch({{3, 2}})[1] == 2);
    CHECK(Plane(InterfaceLaw::undrained).touch({{3, -2}}, 0, told(0, 0.5))[0] == doctest::Approx(3 - most / 2));
    CHECK(Plane(InterfaceLaw::undrained).touch({{3, 2}}, 0, NodeGap{})[0] == 3);
}

TEST_CASE("the moment of what a node gives is its arm times the impulse") {
    Plane plane(InterfaceLaw::smooth);
    plane.touch({{3, -2}});
    CHECK(plane.quantum.value(plane.sums.sum[2]) == doctest::Approx((-4 + 5 * 0.5) * -0.8));
    CHECK(plane.quantum.value(plane.sums.sum[3]) == 0);  // nothing follows along a smooth plane
    CHECK(plane.quantum.value(plane.sums.sum[4]) == doctest::Approx(0.4));
}

TEST_CASE(
    "a node meets a structure that turns at the velocity that it has there, and the moment is that of the impulse") {
    Plane plane(InterfaceLaw::coulomb);
    plane.structure.turns = true;
    plane.structure.turn = identity<double, 2>();
    plane.structure.spin = {{2}};
    plane.structure.velocity = {{0, 0}};
    plane.structure.at = {{0.5, 0}};
    const double arm = (-4 + 5 * 0.5) - 0.5;  // so it goes up there by 2 arm
    const Vec<double, 2> v = plane.touch({{0.01, 3 * arm}});
    CHECK(v[1] == doctest::Approx(2 * arm));
    CHECK(std::fabs(v[0]) < 1e-15);  // friction stops it
    const auto value = [&](const ExactSum& sum) { return plane.quantum.value(sum); };
    const double px = value(plane.sums.sum[0]), py = value(plane.sums.sum[1]);
    CHECK(px == doctest::Approx(0.4 * 0.01));
    CHECK(py == doctest::Approx(0.4 * arm));
    CHECK(value(plane.sums.sum[2]) == doctest::Approx(arm * py));
    CHECK(value(plane.sums.sum[StructureSums<2>::work]) == doctest::Approx(2 * arm * py));
    // all of its mass follows: across, along, and by its arm
    const double m = 0.4, expected[] = {m, 0, 0, m, m * arm, m * arm * arm};
    for (int q = 0; q < 6; ++q) CHECK(value(plane.turning.sum[q]) == doctest::Approx(expected[q]));
}

TEST_CASE("Voellmy's drag acts where soil lies, pressed or not, at the speed that it leaves") {
    Plane lifted(InterfaceLaw::voellmy), pressed(InterfaceLaw::voellmy), held(InterfaceLaw::voellmy);
    const double drag = 3 * 0.5 * 0.1 / 0.4;  // cap A dt / m [s/m]; the plane goes ahead with 1 m/s
    const Vec<double, 2> free = lifted.touch({{3, 2}}), slid = pressed.touch({{3, -1}});
    CHECK(free[1] == 2);
    CHECK(free[0] - 1 + drag * (free[0] - 1) * (free[0] - 1) == doctest::Approx(2));
    CHECK(slid[1] == doctest::Approx(0));
    CHECK(slid[0] - 1 + drag * (slid[0] - 1) * (slid[0] - 1) == doctest::Approx(2 - 0.5 * 1));
    CHECK(held.touch({{1.3, -1}})[0] == doctest::Approx(1));  // friction alone stops it
}
