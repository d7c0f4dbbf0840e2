#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "core/sample_ground.hpp"
#include "core/structures/ground_bound.hpp"

using namespace moraine;

namespace {

template <class F>
Ground ground_of(std::int64_t n, double spacing, bool profile, const F& f) {
    return test::ground_of({-3.0, 2.0}, n, spacing, profile, f);
}

constexpr double reach = 2;

}  // namespace

TEST_CASE("the ground goes through the heights of the model") {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> height(-2, 2);
    const auto any = [&](double, double) { return height(random); };
    const Ground raster = ground_of(9, 0.5, false, any), profile = ground_of(9, 0.5, true, any);
    for (std::size_t j = 0; j < 9; ++j)
        for (std::size_t i = 0; i < 9; ++i) {
            const double x = -3 + 0.5 * double(i), y = 2 + 0.5 * double(j);
            CHECK(ground_at<3>(raster.table.data(), {{x, y, 0}}).height == doctest::Approx(raster.height[i + 9 * j]));
            if (j == 0)
                CHECK(ground_at<2>(profile.table.data(), {{x, 0}}).height == doctest::Approx(profile.height[i]));
        }
}

TEST_CASE("a plane is exact in distance and normal, to half a cell beyond the last node") {
    const Ground raster = ground_of(8, 0.5, false, [](double x, double y) { return 1 + 0.3 * x - 0.5 * y; });
    const Ground profile = ground_of(8, 0.5, true, [](double x, double) { return 1 + 0.3 * x; });
    const double length = std::sqrt(1 + 0.09 + 0.25), flat = std::sqrt(1.09);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> along(-3.1, 0.6), up(-0.1, 0.1);
    for (int k = 0; k < 200; ++k) {
        const double x = along(random), y = 5 + x, d = up(random);
        const double z = 1 + 0.3 * x - 0.5 * y, low = 1 + 0.3 * x;
        const auto s = ground_surface<3>(raster.table.data(), reach,
                                         {{x - 0.3 * d / length, y + 0.5 * d / length, z + d / length}});
        CHECK(s.distance == doctest::Approx(d).epsilon(1e-9));
        CHECK(s.normal[1] == doctest::Approx(0.5 / length));
        const auto t = ground_surface<2>(profile.table.data(), reach, {{x - 0.3 * d / flat, low + d / flat}});
        CHECK(t.distance == doctest::Approx(d).epsilon(1e-9));
        CHECK(t.normal[0] == doctest::Approx(-0.3 / flat));
    }
    CHECK(ground_at<2>(profile.table.data(), {{-3.25, 0}}).height == doctest::Approx(1 - 0.3 * 3.25));
}

TEST_CASE("in a bowl the distance by one foot point is within 0.004 cells of the true one") {
    const double radius = 20, h = 1;
    const auto bowl = [&](double x, double y) {
        return -std::sqrt(std::max(1.0, radius * radius - x * x - (y - 25) * (y - 25)));
    };
    const Ground g = ground_of(120, 0.25, false, [&](double x, double y) { return bowl(x - 12, y + 8); });
    double worst = 0;
    for (double r = 0; r < 12; r += 0.7)
        for (double turn = 0; turn < 6.3; turn += 0.3) {
            const double x = r * std::cos(turn), y = r * std::sin(turn), z = bowl(x, y + 25);
            for (double d : {-0.65, 0.3, 0.65}) {  // towards the centre of the sphere
                const double f = 1 - d * h / radius;
                const auto s = ground_surface<3>(g.table.data(), reach, {{x * f + 12, y * f + 17, z * f}});
                REQUIRE(std::isfinite(s.distance));
                worst = std::max(worst, std::fabs(s.distance - d * h));
            }
        }
    CAPTURE(worst);
    CHECK(worst <= 0.004 * h);
}

TEST_CASE("what is far from the ground gets a bound that no distance undercuts and no way outruns") {
    const Ground g =
        ground_of(40, 0.25, false, [](double x, double y) { return std::sin(1.5 * x) + 0.5 * std::cos(2 * y + x); });
    Structure<3> s{};
    s.shape = StructureShape::ground;
    s.radius = reach;
    const auto bound = [&](const Vec<double, 3>& x) { return distance_bound(s, g.table.data(), x); };
    std::mt19937 random(3);
    std::uniform_real_distribution<double> along(-3, 6), across(2, 11), up(-4, 6);
    for (int k = 0; k < 500; ++k) {
        const Vec<double, 3> x{{along(random), across(random), up(random)}};
        const Vec<double, 3> y{{along(random), across(random), up(random)}};
        CHECK(std::fabs(bound(x) - bound(y)) <= magnitude(x - y) + 1e-12);
        const Vec<double, 3> on{{y[0], y[1], ground_at<3>(g.table.data(), y).height}};
        CHECK(std::fabs(bound(x)) <= magnitude(x - on) + 1e-12);
    }
}

TEST_CASE("what a block's plane says of a point is true of its distance, and on smooth ground it says much") {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (double roughness : {0.0, 0.05, 0.3, 1.5}) {
        const Ground g = ground_of(60, 0.5, false, [&](double x, double y) {
            return 3 + 0.4 * x - 0.2 * y + roughness * (std::sin(1.1 * x + y) + 0.2 * unit(random));
        });
        Structure<3> s{};
        s.shape = StructureShape::ground;
        s.radius = reach;
        const double cell = 1, half = 2;
        int over = 0, away = 0, truly_over = 0, truly_away = 0;
        for (int k = 0; k < 400; ++k) {
            const Vec<double, 3> foot{{10 + 8 * unit(random), 16 + 8 * unit(random), 0}};
            Vec<double, 3> middle = foot;
            middle[2] = ground_at<3>(g.table.data(), foot).height + 4 * unit(random);
            const GroundBound<3> bound = bound_ground(s, g.table.data(), middle, half, 1.5 * cell);
            for (int n = 0; n < 20; ++n) {
                Vec<double, 3> x;
                for (int a = 0; a < 3; ++a) x[a] = middle[a] + half * unit(random);
                const double gap = x[2] - ground_at<3>(g.table.data(), x).height;
                const double distance = ground_surface<3>(g.table.data(), s.radius, x).distance;
                over += bound.is_over(x), truly_over += gap > 0;
                away += bound.is_clear(x), truly_away += distance >= 1.5 * cell;
                if (bound.is_over(x)) REQUIRE(gap > 0);
                if (bound.is_clear(x) || bound.is_clear_block(half)) REQUIRE(distance >= 1.5 * cell);
            }
        }
        CAPTURE(roughness);
        if (roughness < 0.1) CHECK(over > 0.8 * truly_over);
        if (roughness == 0) CHECK(away > 0.95 * truly_away);
        if (roughness < 0.1) CHECK(away > 0.5 * truly_away);
    }
}

TEST_CASE("beyond the model a block's plane says nothing") {
    const Ground g = ground_of(20, 0.5, false, [](double x, double) { return x; });
    Structure<3> s{};
    s.shape = StructureShape::ground;
    s.radius = reach;
    const GroundBound<3> bound = bound_ground<3>(s, g.table.data(), {{-3.0, 6.0, 40.0}}, 2.0, 1.5);
    CHECK_FALSE(bound.is_over({{-3.0, 6.0, 40.0}}));
    CHECK_FALSE(bound.is_clear_block(2.0));
}
