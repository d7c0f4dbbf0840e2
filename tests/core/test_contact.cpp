#include <doctest/doctest.h>

#include <cmath>

#include "core/shape.hpp"
#include "core/structure_set.hpp"

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

/// Mass of a node over that of a full one, `s` cells outside of a half-space of many particles, by the shape functions.
template <class S>
double filled(double s, double half) {
    const int per_cell = 400;
    double sum = 0;
    for (int k = 0; k < 6 * per_cell; ++k) {
        const double x = s + (k + 0.5) / per_cell;  // particle from the node
        const double from = x - double(S::template reach<double>);
        const int base = static_cast<int>(std::floor(from));
        double w[S::width], dw[S::width];
        S::weights(from - base, half, w, dw);
        if (base <= 0 && -base < S::width) sum += w[-base] / per_cell;
    }
    return sum;
}

template <class S>
double worst_fill(moraine::Shape shape) {
    const Scene scene = plane_scene(shape, {0, 1, 0});
    const StructureSet<2> set(scene);
    double worst = 0;
    for (double s = -2; s <= 2; s += 0.05)
        worst = std::max(worst, std::fabs(fill(set.field(), s) - filled<S>(s, 0.25)));
    return worst;
}

/// The plane's field with sums to add to, and its one node.
struct Plane {
    Scene scene;
    StructureSet<2> set;
    StructureSums<2> sums;
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
    Vec<double, 2> touch(Vec<double, 2> v, int above = 0, double mass = 0.4) {
        const int node[2] = {5, 8 + above};
        Vec<double, 2> given = zero_vec<double, 2>();
        touch_structures(field, node, mass, 0.1, true, quantum, v, given);
        for (int a = 0; a < 2; ++a) CHECK(quantum.value(sums.sum[a]) == doctest::Approx(given[a]));
        return v;
    }
};

}  // namespace

TEST_CASE("fill is the mass of a node beside a half-space for every shape") {
    CHECK(worst_fill<Linear>(moraine::Shape::linear) < 1e-3);
    CHECK(worst_fill<Quadratic>(moraine::Shape::quadratic) < 1e-3);
    CHECK(worst_fill<Gimp>(moraine::Shape::gimp) < 1e-3);
    CHECK(worst_fill<Cubic>(moraine::Shape::cubic) < 0.01);
}

TEST_CASE("the nodes' areas add up to the area of the contact, whatever the plane's place and slope") {
    for (double degrees : {0.0, 17.0, 45.0, 90.0})
        for (double shift : {0.0, 0.13, 0.37}) {
            CAPTURE(degrees);
            CAPTURE(shift);
            const double angle = degrees * 3.14159265358979323846 / 180;
            const Triple normal{-std::sin(angle), std::cos(angle), 0};
            const Scene scene =
                plane_scene(moraine::Shape::quadratic, normal, {shift * normal[0], shift * normal[1], 0});
            const StructureSet<2> set(scene);
            const ContactField<2> f = set.field();
            double area = 0;
            const double half = 20;  // nodes of a strip along the plane, far longer than the stencil
            for (int i = -60; i <= 60; ++i)
                for (int j = -60; j <= 60; ++j) {
                    const int node[2] = {8 + i, 8 + j};
                    const double along = i * std::cos(angle) + j * std::sin(angle);
                    if (std::fabs(along) > half) continue;
                    const double d = (i * normal[0] + j * normal[1]) - shift / 0.5;
                    area += look_at(f, f.structure[0], node, 0.5 * fill(f, -d)).area;
                }
            CHECK(area == doctest::Approx(2 * half * 0.5).epsilon(0.03));
        }
}

TEST_CASE("a pressed node loses its velocity into the surface and nothing else on a smooth one") {
    Plane plane(InterfaceLaw::smooth);
    const Vec<double, 2> v = plane.touch({{3, -2}});
    CHECK(v[0] == 3);
    CHECK(v[1] == doctest::Approx(0).epsilon(1e-12));
    CHECK(plane.quantum.value(plane.sums.sum[1]) == doctest::Approx(-0.8));
}

TEST_CASE("a node that leaves the structure, or has too little mass for its soil to be there, is free") {
    Plane plane(InterfaceLaw::rough);
    CHECK(plane.touch({{3, 2}})[1] == 2);
    CHECK(plane.touch({{3, -2}}, 0, 0.1)[1] == -2);
    CHECK(plane.touch({{3, -2}}, 1)[1] == -2);
    CHECK(plane.touch({{3, -2}}, -1, 0.1)[1] == doctest::Approx(0));
}

TEST_CASE("a node is held wholly up to 0.65 cells outside the surface, and not at all from 0.75 on") {
    const auto left = [](double below) {
        Plane plane(InterfaceLaw::smooth);
        plane.structure.at[1] += (1 - below) * 0.5;  // node 9 is this many cells over it
        return plane.touch({{3, -2}}, 1, 0.5)[1];
    };
    CHECK(left(0.3) == doctest::Approx(0).epsilon(1e-12));
    CHECK(left(0.6) == doctest::Approx(0).epsilon(1e-12));
    CHECK(left(0.7) == doctest::Approx(-1));
    CHECK(left(0.8) == -2);
}

TEST_CASE("a node is held wholly once its soil is within 0.05 cells of the surface, and not at all at 0.15") {
    const auto left = [](double gap) {
        Plane plane(InterfaceLaw::smooth);
        return plane.touch({{3, -2}}, 0, 0.5 * fill(plane.field, gap))[1];
    };
    CHECK(left(0.04) == doctest::Approx(0).epsilon(1e-12));
    CHECK(left(0.1) < -0.5);
    CHECK(left(0.1) > -1.5);
    CHECK(left(0.16) == -2);
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
    CHECK(Plane(InterfaceLaw::undrained).touch({{3, 2}}, 0, 0.1)[0] == 3);
}

TEST_CASE("the moment of what a node gives is its arm times the impulse") {
    Plane plane(InterfaceLaw::smooth);
    plane.touch({{3, -2}});
    CHECK(plane.quantum.value(plane.sums.sum[2]) == doctest::Approx((-4 + 5 * 0.5) * -0.8));
    CHECK(plane.quantum.value(plane.sums.sum[3]) == 0);  // nothing follows along a smooth plane
    CHECK(plane.quantum.value(plane.sums.sum[4]) == doctest::Approx(0.4));
}
