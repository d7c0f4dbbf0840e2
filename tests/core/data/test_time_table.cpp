#include <doctest/doctest.h>

#include "core/data/time_table.hpp"

using namespace moraine;

namespace {
const TimeTable table{{1, 2, 4}, {3, -1, 5}};
}  // namespace

TEST_CASE("a table is linear between its rows, and constant before the first and after the last") {
    CHECK(table.at(0) == 3);
    CHECK(table.at(1) == 3);
    CHECK(table.at(1.5) == 1);
    CHECK(table.at(2) == -1);
    CHECK(table.at(3) == 2);
    CHECK(table.at(4) == 5);
    CHECK(table.at(9) == 5);
    CHECK(table.end() == 4);
    CHECK(table.largest() == 5);
}

TEST_CASE(
    "a mean is the value in the middle of a piece, whatever rows fall into a step, and exact where it is constant") {
    CHECK(table.mean(1.2, 1.6) == doctest::Approx(table.at(1.4)));
    CHECK(table.mean(0, 1) == 3);
    CHECK(table.mean(4.1, 4.3) == 5);
    CHECK(table.mean(0.1, 0.3) == 3);
    CHECK(table.mean(1, 4) == doctest::Approx((1.0 + 4.0) / 3));
    CHECK(table.mean(0, 6) == doctest::Approx((3.0 + 1.0 + 4.0 + 10.0) / 6));
    CHECK(table.mean(1.5, 2.5) == doctest::Approx((0.0 + 0.5 * (-1 + 0.5)) * 0.5));
}

TEST_CASE("means of steps of any length add up to the integral of the table") {
    double sum = 0, t = 0;
    for (int k = 0; t < 6; ++k) {
        const double dt = 0.01 + 0.37 * ((k * 7) % 5), to = t + dt;
        sum += table.mean(t, to) * dt;
        t = to;
    }
    CHECK(sum == doctest::Approx(8 + 5 * (t - 4)).epsilon(1e-14));
}
