#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "core/surfaces/cut_cell.hpp"

using namespace moraine;

namespace {

template <int Dim>
CellBox<Dim> open_box() {
    CellBox<Dim> box;
    for (int a = 0; a < Dim; ++a) {
        box.end[a][0] = -0.5, box.end[a][1] = 0.5;
        box.basis[a] = cell_basis<double>(0);
    }
    return box;
}

/// The cell at `node` of a plane with this normal through `point`, all in cells.
template <int Dim>
CutCell<Dim> cut_by_plane(const Vec<double, Dim>& node, const Vec<double, Dim>& normal, double offset,
                          CutFaces<Dim>* faces = nullptr) {
    double distance[1 << Dim];
    const CellBox<Dim> box = open_box<Dim>();
    for (int k = 0; k < 1 << Dim; ++k) {
        Vec<double, Dim> x = node;
        for (int a = 0; a < Dim; ++a) x[a] += box.end[a][k >> a & 1];
        distance[k] = dot(x, normal) - offset;
    }
    return CellCutter<Dim>().cut(box, distance, faces);
}

template <int Dim>
Vec<double, Dim> random_direction(std::mt19937& random) {
    std::normal_distribution<double> any;
    Vec<double, Dim> n;
    for (int a = 0; a < Dim; ++a) n[a] = any(random);
    return (1 / magnitude(n)) * n;
}

template <int N>
struct Dimension {
    static constexpr int dim = N;
};

}  // namespace

TYPE_TO_STRING_AS("2-D", Dimension<2>);
TYPE_TO_STRING_AS("3-D", Dimension<3>);

TEST_CASE_TEMPLATE("open faces and the surface of a cell close, and weights and volumes add up", D, Dimension<2>,
                   Dimension<3>) {
    constexpr int dim = D::dim;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> offset(-0.8, 0.8);
    for (int k = 0; k < 300; ++k) {
        const Vec<double, dim> n = random_direction<dim>(random);
        CutFaces<dim> of;
        const CutCell<dim> cell = cut_by_plane<dim>(zero_vec<double, dim>(), n, offset(random), &of);
        Vec<double, dim> faces = zero_vec<double, dim>(), bed = faces;
        double inside = 0, weights = 0;
        for (int i = 0; i < cell.nodes; ++i) {
            faces = faces - (-1.0) * of.face[i], bed = bed - (-1.0) * of.bed[i];
            inside += cell.inside[i];
            if (cell.area > 0) weights += cell.weight[i];
        }
        REQUIRE(magnitude(faces - bed) < 1e-12);
        REQUIRE(inside == doctest::Approx(cell.volume).epsilon(1e-12));
        if (!(cell.area > 1e-6)) continue;
        REQUIRE(weights == doctest::Approx(1).epsilon(1e-12));
        REQUIRE(magnitude(cell.normal - n) < 1e-9);
    }
}

TEST_CASE_TEMPLATE("a uniform pressure gives nothing at any node, at any angle", D, Dimension<2>, Dimension<3>) {
    constexpr int dim = D::dim;
    constexpr int side = 7;
    std::mt19937 random(2);
    for (int k = 0; k < 20; ++k) {
        const Vec<double, dim> n = random_direction<dim>(random);
        Vec<double, dim> at_node = zero_vec<double, dim>();  // of the middle node, from the cells around it
        each_node<dim, 3>([&](int, int i, int j, int l) {
            Vec<double, dim> node = zero_vec<double, dim>();
            const int offset[3] = {i - 1, j - 1, l - 1};
            int own = 0;
            for (int a = dim - 1; a >= 0; --a) node[a] = offset[a], own = 3 * own + (1 - offset[a]);
            CutFaces<dim> of;
            cut_by_plane<dim>(node, n, 0.37 * std::sin(double(k)), &of);
            at_node = at_node - (-1.0) * of.face[own];
        });
        CAPTURE(side);
        REQUIRE(magnitude(at_node) < 1e-12);
    }
}

TEST_CASE("a surface along the faces of cells belongs to the cells outside") {
    for (double noise : {-1e-12, 0.0, 1e-12}) {
        const CutCell<2> over = cut_by_plane<2>({{0, 0}}, {{0, 1}}, -0.5 + noise);
        const CutCell<2> under = cut_by_plane<2>({{0, -1}}, {{0, 1}}, -0.5 + noise);
        CHECK(over.volume == doctest::Approx(1));
        CHECK(over.area == doctest::Approx(1));
        CHECK(under.volume < least_volume);
        CHECK(under.area < 1e-9);
    }
}

TEST_CASE("the surface of a cell knows where it is") {
    const CutCell<2> cell = cut_by_plane<2>({{0, 0}}, {{0.6, 0.8}}, 0.1);
    CHECK(dot(cell.centre, Vec<double, 2>{{0.6, 0.8}}) == doctest::Approx(0.1));
    double x = 0, y = 0;
    for (int i = 0; i < 9; ++i) x += cell.weight[i] * (i % 3 - 1), y += cell.weight[i] * (i / 3 - 1);
    CHECK(x == doctest::Approx(cell.centre[0]));
    CHECK(y == doctest::Approx(cell.centre[1]));
}

TEST_CASE("a cube is cut alike along all of its axes") {
    double volume[3];
    for (int a = 0; a < 3; ++a) {
        double distance[8];
        for (int k = 0; k < 8; ++k) {  // a sphere around a corner of the axis a
            Vec<double, 3> x;
            for (int b = 0; b < 3; ++b) x[(a + b) % 3] = (k >> ((a + b) % 3) & 1) - 0.5 + (b == 0 ? 0.4 : 0.1);
            distance[k] = magnitude(x) - 0.7;
        }
        volume[a] = CellCutter<3>().cut(open_box<3>(), distance, nullptr).volume;
    }
    CHECK(volume[0] == doctest::Approx(volume[1]).epsilon(1e-12));
    CHECK(volume[0] == doctest::Approx(volume[2]).epsilon(1e-12));
}
