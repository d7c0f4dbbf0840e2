#include <doctest/doctest.h>

#include <random>

#include "records/section_flow.hpp"

using namespace moraine;

namespace {
using InPlan = std::array<double, 2>;
}

TEST_CASE("a way over a line counts to its left as one, to its right as minus one") {
    const std::vector<InPlan> line{{0, 2}, {0, -2}};  // its left is where x grows
    CHECK(crossings(line, {-1, 0}, {1, 0.5}) == 1);
    CHECK(crossings(line, {1, 0.5}, {-1, 0}) == -1);
    CHECK(crossings(line, {-1, 3}, {1, 3}) == 0);
    CHECK(crossings(line, {-2, 0}, {-1, 0}) == 0);
    CHECK(crossings(line, {-1, 0}, {-1, 0}) == 0);
}

TEST_CASE("a way that ends on a line and goes on counts once, one that turns there not at all") {
    const std::vector<InPlan> line{{0, 2}, {0, -2}};
    CHECK(crossings(line, {-1, 0}, {0, 0}) + crossings(line, {0, 0}, {1, 0}) == 1);
    CHECK(crossings(line, {-1, 0}, {0, 0}) + crossings(line, {0, 0}, {-1, 0}) == 0);
}

TEST_CASE("a way through a corner of a line counts once, one that touches it not at all") {
    const std::vector<InPlan> straight{{0, 2}, {0, 0}, {0, -2}}, bent{{-1, 1}, {0, 0}, {-1, -1}};
    CHECK(crossings(straight, {-1, 0}, {1, 0}) == 1);
    CHECK(crossings(bent, {-1, 0}, {1, 0}) == 1);
    CHECK(crossings(bent, {0, 1}, {0, -1}) == 0);
}

TEST_CASE("around a closed line ways in and out count by where they begin and end") {
    const std::vector<InPlan> ring{{0, 0}, {4, 0}, {4, 3}, {1, 4}, {0, 0}};  // its left is inside
    const auto is_inside = [](const InPlan& x) {
        return x[1] > 0 && x[0] < 4 && x[0] + 3 * x[1] < 13 && x[1] < 4 * x[0];
    };
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-2, 6);
    for (int k = 0; k < 2000; ++k) {
        const InPlan p{place(random), place(random)}, q{place(random), place(random)};
        REQUIRE(crossings(ring, p, q) == int(is_inside(q)) - int(is_inside(p)));
    }
}
