#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <limits>

#include "core/grid/shape.hpp"

using namespace moraine;

namespace {

template <class S, class R>
struct Case {
    using Shape = S;
    using Real = R;
};

template <class C>
constexpr double tolerance = 8 * double(std::numeric_limits<typename C::Real>::epsilon());

/// Calls f(place, half size, weights, slopes) all over the cell, for several half sizes where they count.
template <class C, class F>
void each_place(const F& f) {
    using Real = typename C::Real;
    for (double half : {0.5, 0.25, 1.0 / 6, 0.125, 0.4375, 0.01}) {
        for (int k = 0; k <= 1000; ++k) {
            const Real place = Real(k) / Real(1000);
            Real w[C::Shape::width], dw[C::Shape::width];
            C::Shape::weights(place, Real(half), w, dw);
            f(place, Real(half), w, dw);
        }
        if (!C::Shape::sized) return;
    }
}

/// x_i - x_p [cells]
template <class C>
double distance(int i, typename C::Real f) {
    return i - double(f) - double(C::Shape::template reach<typename C::Real>);
}

}  // namespace

TYPE_TO_STRING_AS("linear float", Case<Linear, float>);
TYPE_TO_STRING_AS("linear double", Case<Linear, double>);
TYPE_TO_STRING_AS("gimp float", Case<Gimp, float>);
TYPE_TO_STRING_AS("gimp double", Case<Gimp, double>);
TYPE_TO_STRING_AS("quadratic float", Case<Quadratic, float>);
TYPE_TO_STRING_AS("quadratic double", Case<Quadratic, double>);
TYPE_TO_STRING_AS("cubic float", Case<Cubic, float>);
TYPE_TO_STRING_AS("cubic double", Case<Cubic, double>);

#define EVERY_SHAPE                                                                                           \
    Case<Linear, float>, Case<Linear, double>, Case<Gimp, float>, Case<Gimp, double>, Case<Quadratic, float>, \
        Case<Quadratic, double>, Case<Cubic, float>, Case<Cubic, double>

TEST_CASE_TEMPLATE("weights are positive and add up to one, slopes to zero", C, EVERY_SHAPE) {
    each_place<C>([](auto, auto, const auto* w, const auto* dw) {
        double sum = 0, slopes = 0;
        for (int i = 0; i < C::Shape::width; ++i) {
            REQUIRE(w[i] >= 0);
            sum += double(w[i]);
            slopes += double(dw[i]);
        }
        REQUIRE(std::fabs(sum - 1) <= tolerance<C>);
        REQUIRE(std::fabs(slopes) <= 10 * tolerance<C>);
    });
}

TEST_CASE_TEMPLATE("straight lines are reproduced with their slope", C, EVERY_SHAPE) {
    each_place<C>([](auto f, auto half, const auto* w, const auto* dw) {
        double place = 0, slope = 0;
        for (int i = 0; i < C::Shape::width; ++i) {
            place += double(w[i]) * distance<C>(i, f);
            slope += double(dw[i]) * distance<C>(i, f);
        }
        CAPTURE(f);
        CAPTURE(half);
        REQUIRE(std::fabs(place) <= 4 * tolerance<C>);
        REQUIRE(std::fabs(slope - 1) <= 20 * tolerance<C>);
    });
}

TEST_CASE_TEMPLATE("slopes are the derivatives of the weights", C, EVERY_SHAPE) {
    if (sizeof(typename C::Real) == 4) return;  // differences of float weights say nothing
    each_place<C>([](auto f, auto half, const auto*, const auto* dw) {
        using Real = typename C::Real;
        const Real e = Real(1e-6);
        if (f < e || f > 1 - e) return;
        Real below[C::Shape::width], above[C::Shape::width], unused[C::Shape::width];
        C::Shape::weights(f - e, half, below, unused);
        C::Shape::weights(f + e, half, above, unused);
        for (int i = 0; i < C::Shape::width; ++i)
            REQUIRE(std::fabs(double(above[i] - below[i]) / 2e-6 - double(dw[i])) <= 1e-6 / double(half) + 1e-8);
    });
}

TEST_CASE_TEMPLATE("weights do not jump where a particle passes into the next cell", C, EVERY_SHAPE) {
    using Real = typename C::Real;
    constexpr int width = C::Shape::width;
    for (double half : {0.5, 0.25, 0.125}) {
        Real end[width], start[width], slope_end[width], slope_start[width];
        C::Shape::weights(Real(1), Real(half), end, slope_end);
        C::Shape::weights(Real(0), Real(half), start, slope_start);
        CHECK(std::fabs(double(end[0])) <= tolerance<C>);
        CHECK(std::fabs(double(start[width - 1])) <= tolerance<C>);
        for (int i = 0; i + 1 < width; ++i) {
            CHECK(std::fabs(double(end[i + 1] - start[i])) <= tolerance<C>);
            if (width > 2) CHECK(std::fabs(double(slope_end[i + 1] - slope_start[i])) <= tolerance<C>);
        }
    }
}

TEST_CASE_TEMPLATE("the gimp box of a whole cell is the quadratic spline", Real, float, double) {
    for (int k = 0; k <= 1000; ++k) {
        const Real f = Real(k) / Real(1000);
        Real g[3], dg[3], q[3], dq[3];
        Gimp::weights(f, Real(0.5), g, dg);
        Quadratic::weights(f, Real(0), q, dq);
        for (int i = 0; i < 3; ++i) {
            REQUIRE(std::fabs(double(g[i] - q[i])) <= 4 * double(std::numeric_limits<Real>::epsilon()));
            REQUIRE(std::fabs(double(dg[i] - dq[i])) <= 8 * double(std::numeric_limits<Real>::epsilon()));
        }
    }
}

TEST_CASE("a gimp box much smaller than the cell gives the hat functions") {
    for (int k = 0; k < 100; ++k) {
        const double x = 0.005 + 0.01 * k;  // from node 0
        double g[3], dg[3], w[2], dw[2];
        const int first = x < 0.5 ? -1 : 0;  // binned at floor(x - 1/2)
        Gimp::weights(x - 0.5 - first, 1e-3, g, dg);
        Linear::weights(x, 0.0, w, dw);
        for (int i = 0; i < 2; ++i) {
            REQUIRE(g[i - first] == doctest::Approx(w[i]).epsilon(1e-12));
            REQUIRE(dg[i - first] == doctest::Approx(dw[i]).epsilon(1e-12));
        }
    }
}

TEST_CASE("the tables know each shape as its kernels do") {
    CHECK(stencil_of(moraine::Shape::linear).width == Linear::width);
    CHECK(stencil_of(moraine::Shape::linear).offset() == 0);
    CHECK(stencil_of(moraine::Shape::gimp).width == Gimp::width);
    CHECK(stencil_of(moraine::Shape::gimp_contiguous).offset() == 0.5);
    CHECK(stencil_of(moraine::Shape::quadratic).offset() == Quadratic::origin - Quadratic::reach<double>);
    CHECK(stencil_of(moraine::Shape::cubic).width == Cubic::width);
    CHECK(stencil_of(moraine::Shape::cubic).offset() == Cubic::origin - Cubic::reach<double>);
}
