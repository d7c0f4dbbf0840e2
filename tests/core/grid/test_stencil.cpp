#include <doctest/doctest.h>

#include <set>

#include "core/grid/stencil.hpp"
#include "core/sample.hpp"

using namespace moraine;
using moraine::test::Sample;

namespace {

template <int Dim, class Shape>
void visits_each_node_once() {
    constexpr int side = tile_side(Shape::width);
    for (int cell = 0; cell < Block<Dim>::cells; ++cell) {
        std::set<int> seen;
        each_node<Dim, Shape::width>([&](int at, int i, int j, int k) {
            const int n = tile_offset<Dim, Shape::width>(cell) + at;
            const int place[3] = {i, j, k};
            REQUIRE(n < power<Dim>(side));
            int rest = n;
            for (int a = 0; a < Dim; ++a, rest /= side)
                REQUIRE(rest % side == cell_coordinate<Dim>(cell, a) + place[a]);
            seen.insert(n);
        });
        REQUIRE(seen.size() == static_cast<std::size_t>(power<Dim>(Shape::width)));
    }
}

}  // namespace

TEST_CASE("the stencil of every cell lies in the tile of its block and has each node once") {
    visits_each_node_once<2, Linear>();
    visits_each_node_once<2, Quadratic>();
    visits_each_node_once<2, Cubic>();
    visits_each_node_once<3, Linear>();
    visits_each_node_once<3, Gimp>();
    visits_each_node_once<3, Cubic>();
}

TEST_CASE("slopes are per metre and places per cell") {
    Sample<double, 2> sample(test::sample_scene(2, moraine::Shape::quadratic, false), 1, 1);
    const auto p = sample.patch.particles.view();
    p.position[0] = {{one_cell<double> / 4, 2 * one_cell<double> + one_cell<double> / 2}};
    const auto n = stencil<double, 2, Quadratic>(sample.method.context, p, 0);
    CHECK(n.f[0] == 0.25);
    CHECK(n.f[1] == 0.5);
    CHECK(n.w[0][0] == 0.5 * 0.75 * 0.75);
    CHECK(n.dw[0][0] == -0.75 / sample.scene.cell);
    CHECK(n.dw[1][2] == 0.5 / sample.scene.cell);
}

TEST_CASE_TEMPLATE("a contiguous gimp box follows the stretch up to half a cell", Real, float, double) {
    Sample<Real, 2> sample(test::sample_scene(2, moraine::Shape::gimp_contiguous, false), 1, 1);
    const auto p = sample.patch.particles.view();
    p.body[0] = 1;  // 1 x 3 particles per cell
    p.log_stretch[0] = {{Real(-0.25), Real(0.25)}};
    const auto& context = sample.method.context;
    CHECK(gimp_half(context, p, 0, 0) == doctest::Approx(0.5 * std::exp(-0.25)));
    CHECK(gimp_half(context, p, 0, 1) == doctest::Approx(0.5 / 3 * std::exp(0.25)));
    p.log_stretch[0] = {{Real(0.25), Real(2)}};
    CHECK(gimp_half(context, p, 0, 0) == Real(0.5));
    CHECK(gimp_half(context, p, 0, 1) == Real(0.5));
}

TEST_CASE("a gimp box without stretch keeps its size") {
    Sample<double, 2> sample(test::sample_scene(2, moraine::Shape::gimp, false), 1, 1);
    const auto p = sample.patch.particles.view();
    p.body[0] = 1;
    CHECK(p.log_stretch == nullptr);
    CHECK(gimp_half(sample.method.context, p, 0, 0) == 0.5);
    CHECK(gimp_half(sample.method.context, p, 0, 1) == doctest::Approx(1.0 / 6));
}
