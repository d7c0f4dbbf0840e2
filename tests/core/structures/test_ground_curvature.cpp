#include <doctest/doctest.h>

#include <cmath>

#include "core/sample_ground.hpp"
#include "core/structures/ground_curvature.hpp"

using namespace moraine;

namespace {

template <class F>
Ground ground_of(std::int64_t n, double spacing, bool profile, const F& f) {  // around the origin
    const double from = -0.5 * spacing * double(n - 1);
    return test::ground_of({from, profile ? 0 : from}, n, spacing, profile, f);
}

}  // namespace

TEST_CASE("a hill and a ridge have the radius of curvature of their tops, and a ridge that falls a larger one") {
    const auto bump = [](double square) { return std::exp(-square / 50); };  // radius 25 at the top
    const auto hill = [&](double x, double y) { return bump(x * x + y * y); };
    const auto ridge = [&](double x, double y) { return bump(0.5 * (x + y) * (x + y) + 0.1 * (x - y) * (x - y)); };
    const auto falls = [&](double x, double y) { return bump(x * x) + 0.8 * y; };
    CHECK(least_radius(ground_of(41, 1.0, false, hill)) == doctest::Approx(25).epsilon(0.02));
    CHECK(least_radius(ground_of(41, 1.0, false, ridge)) == doctest::Approx(25).epsilon(0.02));
    CHECK(least_radius(ground_of(41, 1.0, false, falls)) == doctest::Approx(25 * std::sqrt(1.64)).epsilon(0.02));
    CHECK(least_radius(ground_of(41, 1.0, true, falls)) == doctest::Approx(25).epsilon(0.02));
}

TEST_CASE("a saddle bends as its sharper direction does") {
    const Ground g = ground_of(21, 0.5, false, [](double x, double y) { return 0.5 * (x * x / 10 - y * y / 40); });
    CHECK(least_radius(g) == doctest::Approx(10).epsilon(0.01));
}

TEST_CASE("a plane is not changed, and an edge only where it is and only as far as wanted") {
    Ground plane = ground_of(30, 1.0, false, [](double x, double y) { return 0.3 * x - 0.7 * y; });
    const std::vector<double> before = plane.height;
    CHECK(smooth_ground(plane, 1e4) == 0);
    CHECK(plane.height == before);
    for (bool profile : {false, true}) {
        const auto edge = [](double x, double) { return x < 0.2 ? -0.8 * x : 0; };
        Ground g = ground_of(40, 1.0, profile, edge);
        const Ground sharp = g;
        CHECK(least_radius(g) < 3);
        const double change = smooth_ground(g, 6);
        CHECK(least_radius(g) >= 6);
        CHECK(least_radius(g) < 9);
        CHECK(change > 0);
        CHECK(change < 1);  // the arc of 6 m in an edge of 39 degrees leaves it by 0.37 m
        CHECK(g.height.front() == sharp.height.front());
        CHECK(g.height.back() == sharp.height.back());
    }
}

TEST_CASE("a radius that no smoothing reaches is told") {
    Ground g = ground_of(60, 1.0, false, [](double x, double y) { return x * x + y * y; });
    CHECK(std::isnan(smooth_ground(g, 1e9)));
}
