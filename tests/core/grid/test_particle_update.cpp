#include <doctest/doctest.h>

#include <initializer_list>

#include "core/grid/particle_update.hpp"
#include "core/grid/shape.hpp"

using namespace moraine;

namespace {

/// Walls on both ends of [0, 8] along all axes, ghosts folded.
template <class Real, int Dim>
Walls<Real, Dim> closed_box() {
    Walls<Real, Dim> walls{};
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s) {
            walls.plane[a][s] = 8 * s;
            walls.kind[a][s] = WallKind::no_slip;
            walls.fold[a][s] = true;
        }
    return walls;
}

template <class Shape, class Real>
void levers_of_the_affine_field(Real f) {
    Real w[Shape::width], dw[Shape::width], lever[Shape::width];
    Shape::weights(f, Real(0.25), w, dw);
    affine_levers<Shape>(f, w, dw, Real(4), false, lever);
    Real constant = 0, linear = 0;
    for (int i = 0; i < Shape::width; ++i) {
        constant += lever[i];
        linear += lever[i] * (Real(i) - f - Shape::template reach<Real>);
    }
    CHECK(constant == doctest::Approx(0).epsilon(1e-5));
    CHECK(linear == doctest::Approx(4).epsilon(1e-5));
    affine_levers<Shape>(f, w, dw, Real(4), true, lever);
    for (int i = 0; i < Shape::width; ++i) CHECK(lever[i] == dw[i]);
}

}  // namespace

TEST_CASE_TEMPLATE("the blend is FLIP to the bit at 1, PIC at 0, and between them in between", Real, float, double) {
    const Real v = Real(0.1), change = Real(0.3), gathered = Real(0.7);
    CHECK(blended_velocity(Real(1), v, change, gathered) == v + change);
    CHECK(blended_velocity(Real(0), v, change, gathered) == gathered);
    CHECK(blended_velocity(Real(0.25), v, change, gathered) == doctest::Approx(0.25 * 0.4 + 0.75 * 0.7));
}

TEST_CASE("a tensor of slopes has the component first and the axis second") {
    const double slopes[2][2] = {{1, 2}, {3, 4}};  // [axis][component]
    const Mat<double, 2> m = tensor_of<2>(0.5, slopes);
    CHECK(m(0, 0) == 0.5);
    CHECK(m(0, 1) == 1.5);
    CHECK(m(1, 0) == 1);
    CHECK(m(1, 1) == 2);
}

TEST_CASE_TEMPLATE("levers give a linear field its slope and a constant nothing", Real, float, double) {
    for (Real f : {Real(0.125), Real(0.5), Real(0.9)}) {
        levers_of_the_affine_field<Quadratic>(f);
        levers_of_the_affine_field<Cubic>(f);
        levers_of_the_affine_field<Gimp>(f);
    }
}

TEST_CASE("the affine field is the gradient with TPIC, with hats, and where a ghost was folded") {
    const auto never = [] { return false; };
    const auto folded = [] { return true; };
    CHECK(affine_is_gradient<Quadratic>(true, never));
    CHECK(affine_is_gradient<Linear>(false, never));
    CHECK(affine_is_gradient<Quadratic>(false, folded));
    CHECK_FALSE(affine_is_gradient<Quadratic>(false, never));
}

TEST_CASE("the stencils of the cells at a closed end reach its ghost node, and no others") {
    const auto walls = closed_box<double, 2>();
    CHECK(first_node<Quadratic>(1) == 3);
    CHECK(reaches_ghost<Quadratic>(walls, 0, 0, 0));
    CHECK_FALSE(reaches_ghost<Quadratic>(walls, 1, 0, 1));
    CHECK_FALSE(reaches_ghost<Quadratic>(walls, 0, 1, 3));  // nodes 6, 7, 8
    CHECK(reaches_ghost<Cubic>(walls, 0, 1, 3));            // 6, ..., 9
    CHECK_FALSE(reaches_ghost<Linear>(walls, 0, 1, 3));
}

TEST_CASE_TEMPLATE("a box follows the stretch and enters the shape function with half a cell at most", Real, float,
                   double) {
    const Real ln = advanced_stretch(advanced_stretch(Real(0), Real(0.5)), Real(1));
    CHECK(ln == doctest::Approx(std::log(3.0)));
    CHECK(stretched_half(Real(0.125), ln) == doctest::Approx(0.375));
    CHECK(held_half(Real(0.375)) == Real(0.375));
    CHECK(held_half(stretched_half(Real(0.25), ln)) == Real(0.5));
}

TEST_CASE("a round moves particles by the first quad, and by the second where it says so") {
    CHECK(moves_particles(gather_velocity | gather_motion));
    CHECK(moves_particles(gather_gradient | gather_second_motion));
    CHECK_FALSE(moves_particles(gather_velocity | gather_gradient));
    CHECK(moving_velocity(gather_motion | gather_gradient, 1.0, 2.0) == 1.0);
    CHECK(moving_velocity(gather_second_motion, 1.0, 2.0) == 2.0);
}
