#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/grid/shape.hpp"
#include "core/grid/walls.hpp"
#include "core/transfer/scene_walls.hpp"

using namespace moraine;

namespace {

constexpr int upper = 9;  ///< node of the upper face; the lower one is 0

template <class S, class R>
struct Case {
    using Shape = S;
    using Real = R;
};

/// Weights of a particle at x [cells], 0 <= x <= upper, when the ghosts' share has gone to the nodes they follow.
template <class C>
struct Folded {
    using Real = typename C::Real;
    static constexpr int width = C::Shape::width;
    static constexpr int side = tile_side(width);
    Real w[width], dw[width];
    int base;
    bool folded;

    explicit Folded(double x, double half = 0.25, bool lower_on = true, bool upper_on = true) {
        const double reach = double(C::Shape::template reach<Real>);
        base = static_cast<int>(std::floor(x - reach));
        C::Shape::weights(static_cast<Real>(x - reach - base), static_cast<Real>(half), w, dw);
        Walls<Real, 2> walls{};
        walls.plane[0][1] = upper;
        walls.fold[0][0] = lower_on, walls.fold[0][1] = upper_on;
        const unsigned ghosts = walls.ghosts(0, base, width);
        folded = ghosts != 0;
        Real direct[width], slopes[width];
        std::copy_n(w, width, direct);
        std::copy_n(dw, width, slopes);
        fold_weights<width>(ghosts, direct, slopes);
        fold(walls, w);
        fold(walls, dw);
        for (int i = 0; i < width; ++i) {  // particle by particle or per tile
            REQUIRE(w[i] == direct[i]);
            REQUIRE(dw[i] == slopes[i]);
        }
    }

  private:
    /// As the first row of a tile.
    void fold(const Walls<Real, 2>& walls, Real* values) const {
        Real tile[side * side] = {};
        std::copy_n(values, width, tile);
        const int origin[2] = {base, 4};
        each_ghost(walls, origin, side, [&](int ghost, int step) {
            tile[ghost + step] += 2 * tile[ghost];
            tile[ghost + 2 * step] -= tile[ghost];
            tile[ghost] = 0;
        });
        std::copy_n(tile, width, values);
    }
};

template <class F>
void each_place(const F& f) {
    for (int k = 0; k <= upper * 200; ++k) f(k / 200.0);
}

}  // namespace

TYPE_TO_STRING_AS("gimp float", Case<Gimp, float>);
TYPE_TO_STRING_AS("gimp double", Case<Gimp, double>);
TYPE_TO_STRING_AS("quadratic float", Case<Quadratic, float>);
TYPE_TO_STRING_AS("quadratic double", Case<Quadratic, double>);
TYPE_TO_STRING_AS("cubic float", Case<Cubic, float>);
TYPE_TO_STRING_AS("cubic double", Case<Cubic, double>);
#define WIDE_SHAPES                                                                                             \
    Case<Gimp, float>, Case<Gimp, double>, Case<Quadratic, float>, Case<Quadratic, double>, Case<Cubic, float>, \
        Case<Cubic, double>

TEST_CASE_TEMPLATE("folded weights keep constants and straight lines, are positive and leave the ghost alone", C,
                   WIDE_SHAPES) {
    const double eps = double(std::numeric_limits<typename C::Real>::epsilon());
    for (double half : {0.5, 0.25, 0.125})
        each_place([&](double x) {
            const Folded<C> n(x, half);
            double sum = 0, place = 0, slopes = 0, slope = 0;
            for (int i = 0; i < C::Shape::width; ++i) {
                const int node = n.base + i;
                REQUIRE(double(n.w[i]) >= -eps);
                if (node < 0 || node > upper) {
                    REQUIRE(n.w[i] == 0);
                    REQUIRE(n.dw[i] == 0);
                }
                sum += double(n.w[i]);
                place += double(n.w[i]) * (node - x);
                slopes += double(n.dw[i]);
                slope += double(n.dw[i]) * (node - x);
            }
            CAPTURE(x);
            REQUIRE(std::fabs(sum - 1) <= 8 * eps);
            REQUIRE(std::fabs(place) <= 64 * eps);
            REQUIRE(std::fabs(slopes) <= 64 * eps);
            REQUIRE(std::fabs(slope - 1) <= 256 * eps);
        });
}

TEST_CASE_TEMPLATE("a wall node at rest holds the wall itself at rest", C, WIDE_SHAPES) {
    const double eps = double(std::numeric_limits<typename C::Real>::epsilon());
    for (double x : {0.0, double(upper)}) {
        const Folded<C> n(x);
        for (int i = 0; i < C::Shape::width; ++i)
            CHECK(std::fabs(double(n.w[i]) - (n.base + i == int(x) ? 1 : 0)) <= 4 * eps);
    }
}

TEST_CASE_TEMPLATE("folding tells whether there was a ghost, and open faces do not fold", C, WIDE_SHAPES) {
    const double near = C::Shape::width == 4 ? 0.9 : 0.4;
    const double far = C::Shape::width == 4 ? 1.1 : 0.6;
    CHECK(Folded<C>(near).folded);
    CHECK(Folded<C>(upper - near).folded);
    CHECK(!Folded<C>(far).folded);
    CHECK(!Folded<C>(upper - far).folded);
    CHECK(!Folded<C>(near, 0.5, false, true).folded);
    CHECK(!Folded<C>(upper - near, 0.5, true, false).folded);
    CHECK(Folded<C>(near, 0.5, false, true).w[0] > 0);
}

TEST_CASE("the quadratic spline becomes the hat function in the last half cell") {
    for (double x : {0.0, 0.1, 0.25, 0.49}) {
        const Folded<Case<Quadratic, double>> n(x);
        CHECK(n.w[1] == doctest::Approx(1 - x).epsilon(1e-14));
        CHECK(n.w[2] == doctest::Approx(x).epsilon(1e-14));
    }
}

TEST_CASE_TEMPLATE("walls hold the nodes on them and behind them", Real, float, double) {
    Walls<Real, 3> walls{};
    for (int a = 0; a < 3; ++a) walls.plane[a][1] = 10;
    walls.kind[0][0] = WallKind::no_slip;
    walls.kind[1][0] = WallKind::free_slip;
    walls.kind[2][1] = WallKind::friction;
    walls.friction[2][1] = Real(0.5);
    const auto at = [&](int i, int j, int k) {
        Vec<Real, 3> v{{3, 4, 10}};
        const int node[3] = {i, j, k};
        walls.constrain(node, v);
        return v;
    };
    CHECK(at(5, 5, 5)[2] == 10);
    for (int i : {0, -1})
        for (int a = 0; a < 3; ++a) CHECK(at(i, 5, 5)[a] == 0);
    CHECK(at(5, 0, 5)[0] == 3);
    CHECK(at(5, -1, 5)[1] == 0);
    CHECK(at(10, 10, 5)[0] == 3);  // no wall there
    CHECK(at(5, 5, 10)[2] == 0);   // pressed: mu 10 = 5 is all of the speed along the wall
    CHECK(at(5, 5, 10)[0] == 0);
    walls.friction[2][1] = Real(0.1);  // takes 1 of 5
    CHECK(at(5, 5, 11)[0] == doctest::Approx(2.4));
    CHECK(at(5, 5, 11)[1] == doctest::Approx(3.2));
    CHECK(at(0, 5, 10)[2] == 0);  // in a corner both act
    Vec<Real, 3> leaving{{3, 4, -10}};
    const int node[3] = {5, 5, 10};
    walls.constrain(node, leaving);
    CHECK(leaving[2] == -10);  // a friction wall does not pull
    CHECK(leaving[0] == 3);
}

TEST_CASE("a second velocity stays at a wall with friction where the first was pressed against it") {
    Walls<double, 2> walls{};
    walls.plane[0][1] = walls.plane[1][1] = 8;
    walls.kind[1][0] = WallKind::friction;
    walls.kind[1][1] = WallKind::free_slip;
    const auto second = [&](int x, int y, Vec<double, 2> first) {
        const int node[2] = {x, y};
        Vec<double, 2> v{{3, 4}};
        walls.hold(node, first, v);
        return v;
    };
    const Vec<double, 2> slides{{2, 0}}, sticks{{0, 0}}, leaves{{2, 1}};
    for (int y : {0, -1}) {  // on the wall, and the ghost behind it
        CHECK(second(4, y, slides)[0] == 3);
        CHECK(second(4, y, slides)[1] == 0);
        CHECK(second(4, y, sticks)[0] == 0);
        CHECK(second(4, y, sticks)[1] == 0);
        CHECK(second(4, y, leaves)[1] == 4);
    }
    CHECK(second(4, 1, sticks)[1] == 4);  // inside
    CHECK(second(4, 8, sticks)[1] == 4);  // the other wall has no friction
}

TEST_CASE("only closed walls of stencils that reach a ghost are folded, and only when the scene wants it") {
    Scene scene;
    scene.dimensions = 2;
    scene.max = {2, 1, 0};
    scene.cell = 0.25;
    scene.walls[0][0].kind = WallKind::no_slip;
    scene.walls[0][1].kind = WallKind::open;
    scene.walls[1][0].kind = WallKind::friction;
    scene.walls[1][0].friction = 0.3;
    const Walls<double, 2> walls = make_walls<double, 2>(scene);
    CHECK(walls.plane[0][0] == 0);
    CHECK(walls.plane[0][1] == 8);
    CHECK(walls.plane[1][1] == 4);
    CHECK(walls.fold[0][0]);
    CHECK(!walls.fold[0][1]);
    CHECK(walls.fold[1][0]);
    CHECK(!walls.fold[1][1]);
    CHECK(walls.friction[1][0] == 0.3);
    scene.boundary_spline = false;
    CHECK(!make_walls<double, 2>(scene).fold[0][0]);
    scene.boundary_spline = true;
    scene.shape = moraine::Shape::linear;
    CHECK(!make_walls<double, 2>(scene).fold[0][0]);
}

TEST_CASE("every ghost of a tile is named once, with the way inward, axis after axis") {
    Walls<double, 3> walls{};
    for (int a = 0; a < 3; ++a) walls.plane[a][1] = 4, walls.fold[a][0] = true;
    walls.fold[1][1] = true;
    const int side = 6, origin[3] = {-1, 0, -1};
    std::vector<std::pair<int, int>> seen;
    each_ghost(walls, origin, side, [&](int ghost, int step) { seen.emplace_back(ghost, step); });
    REQUIRE(seen.size() == 3 * 36);  // x below, y above (y below lies outside the tile), z below
    for (std::size_t k = 0; k < 36; ++k) {
        CHECK(seen[k].first % side == 0);
        CHECK(seen[k].second == 1);
        CHECK(seen[36 + k].first / side % side == 5);
        CHECK(seen[36 + k].second == -side);
        CHECK(seen[72 + k].first / (side * side) == 0);
        CHECK(seen[72 + k].second == side * side);
    }
    std::sort(seen.begin(), seen.end());
    CHECK(std::unique(seen.begin(), seen.end()) == seen.end());
}
