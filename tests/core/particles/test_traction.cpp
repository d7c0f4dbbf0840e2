#include <doctest/doctest.h>

#include "core/particles/make_traction.hpp"

using namespace moraine;

namespace {

constexpr double p0 = 3;

template <int Dim>
Traction<double, Dim> pressed(bool follows) {
    Traction<double, Dim> t{};
    t.normal[1] = 1, t.shear[0] = 0.5, t.pressure = p0, t.follows = follows;
    return t;
}

}  // namespace

TEST_CASE("shares of a line of particles add up to one, and chi is one above and none below") {
    for (const double spacing : {0.1, 0.25, 0.3}) {
        double sum = 0, mean = 0;
        for (double d = spacing / 2; d < 2; d += spacing) {
            const LineShare<double> share = line_share(1.0, spacing, 1.0 + spacing / 2 - d);
            sum += share.q * spacing, mean += share.chi * spacing;
            CHECK(share.q >= 0);
        }
        CHECK(sum == doctest::Approx(1).epsilon(1e-14));
        CHECK(mean == doctest::Approx(0.5).epsilon(1e-14));
    }
    CHECK(line_share(1.0, 0.1, 1.0).chi == doctest::Approx(1).epsilon(0.01));
    CHECK(line_share(1.0, 0.1, 0.0).chi == 0);
}

TEST_CASE("a dead traction keeps its direction and size, a follower turns and has the area of now") {
    Mat<double, 2> turned{{{0, -2}, {3, 0}}};  // by 90 degrees, x stretched by 3, y by 2
    const Vec<double, 2> dead = traction_of(pressed<2>(false), turned), follows = traction_of(pressed<2>(true), turned);
    CHECK(dead[0] == doctest::Approx(0.5));
    CHECK(dead[1] == doctest::Approx(-p0));
    CHECK(follows[0] == doctest::Approx(3 * p0));
    CHECK(follows[1] == doctest::Approx(3 * 0.5));
    const double most = traction_of(pressed<2>(true), Mat<double, 2>{{{90, 0}, {0, 1}}})[1];
    CHECK(most == doctest::Approx(-4 * p0));
}

TEST_CASE("a follower in three dimensions has the cofactors of F") {
    const Mat<double, 3> F{{{1.1, 0.2, -0.3}, {0.1, 0.9, 0.4}, {0.0, -0.2, 1.3}}};
    Mat<double, 3> expected = zero_mat<double, 3>();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k) expected(i, j) += cofactors(F)(k, i) * F(k, j);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            CHECK(expected(i, j) == doctest::Approx(i == j ? determinant(F) : 0).epsilon(1e-14));
    const Vec<double, 3> t = traction_of(pressed<3>(true), F);
    const Vec<double, 3> c = times(cofactors(F), Vec<double, 3>{{0, 1, 0}}), s = times(F, Vec<double, 3>{{1, 0, 0}});
    for (int a = 0; a < 3; ++a)
        CHECK(t[a] == doctest::Approx(0.5 * length_of(c) / length_of(s) * s[a] - p0 * c[a]).epsilon(1e-14));
}
