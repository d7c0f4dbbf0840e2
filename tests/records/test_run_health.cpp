#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <tuple>

#include "records/run_health.hpp"

using namespace moraine;

namespace {

constexpr double rounding = 2.2e-16;

/// A flow of 100 J in motion, of which `unaccounted` are missing, with a particle whose volume changed by |ln J|.
TimeSeriesRow<2> row_of(std::int64_t step, double unaccounted, double ln_J = 0) {
    TimeSeriesRow<2> row;
    row.step = step, row.time = 0.1 * static_cast<double>(step);
    row.totals.kinetic = 60;
    row.totals.strain = 30;
    row.dissipated = 20;
    row.potential = 1000;
    row.unaccounted = unaccounted;
    row.totals.stretch = {ln_J, {3, 4}};
    row.totals.speed = {5, {1, 2}};
    return row;
}

std::size_t found(RunHealth<2>& health, const TimeSeriesRow<2>& row) {
    return health.observe(row, 10, rounding).size();
}

}  // namespace

TEST_CASE("a sound run warns of nothing") {
    RunHealth<2> health;
    for (int step = 0; step < 5; ++step) CHECK(found(health, row_of(step, 30, 0.69)) == 0);
    CHECK(found(health, row_of(5, -0.99)) == 0);
    CHECK(found(health, row_of(6, -0.99)) == 0);
}

TEST_CASE("a volume that has doubled or halved is said once, with its place") {
    RunHealth<2> health;
    const auto first = health.observe(row_of(7, 0, 0.70), 10, rounding);
    REQUIRE(first.size() == 1);
    CHECK(first[0].problem == HealthProblem::volume);
    CHECK(first[0].step == 7);
    CHECK(first[0].message().find("at step 7 (t = 0.7 s) a particle at (3, 4) m") != std::string::npos);
    CHECK(first[0].message().find("2.01 times") != std::string::npos);
    CHECK(found(health, row_of(8, 0, 5)) == 0);
    CHECK(health.warnings().size() == 1);
}

TEST_CASE("energy from nowhere is said when two rows in turn have more than one percent of it") {
    RunHealth<2> health;
    CHECK(found(health, row_of(1, -1.1)) == 0);
    CHECK(found(health, row_of(2, -0.9)) == 0);
    CHECK(found(health, row_of(3, -1.1)) == 0);
    const auto second = health.observe(row_of(4, -2), 10, rounding);
    REQUIRE(second.size() == 1);
    CHECK(second[0].problem == HealthProblem::energy);
    CHECK(second[0].amount == doctest::Approx(0.02));
    CHECK(second[0].message().find("2 % more energy") != std::string::npos);
    CHECK(second[0].message().find("(1, 2) m") != std::string::npos);
    CHECK(found(health, row_of(5, -50)) == 0);
}

TEST_CASE("a gain is measured by the most that was ever in motion") {
    RunHealth<2> health;
    CHECK(found(health, row_of(1, 0)) == 0);
    TimeSeriesRow<2> slow = row_of(2, -0.9);
    slow.totals.kinetic = 1;
    CHECK(found(health, slow) == 0);
    CHECK(found(health, slow) == 0);
}

TEST_CASE("a gain is not judged within rounding of the sums, nor once particles have left") {
    TimeSeriesRow<2> still = row_of(1, -1e-5);
    still.totals.kinetic = 1e-4, still.dissipated = 0, still.totals.strain = 10;
    RunHealth<2> health;
    for (int k = 0; k < 3; ++k) CHECK(health.observe(still, 10, 1.2e-7).empty());
    TimeSeriesRow<2> left = row_of(1, -20);
    left.lost_particles = 1;
    for (int k = 0; k < 3; ++k) CHECK(found(health, left) == 0);
}

TEST_CASE("a gain is not judged where gravity pulls along a periodic axis") {
    RunHealth<2> health;
    TimeSeriesRow<2> round = row_of(1, -70);
    round.falls_round = true;
    for (int k = 0; k < 3; ++k) CHECK(found(health, round) == 0);
}

TEST_CASE("a warning names keys that scenes have") {
    RunHealth<2> health;
    health.observe(row_of(1, -2), 10, rounding);
    for (const HealthWarning<2>& w : health.observe(row_of(2, -2, 0.7), 10, rounding))
        CHECK(w.message().find("a smaller time.cfl") != std::string::npos);
    CHECK(health.warnings().size() == 2);
}

TEST_CASE("volume that does not fit is said once, and the largest share is kept") {
    RunHealth<2> health;
    TimeSeriesRow<2> row = row_of(1, 0);
    row.over_filling = std::numeric_limits<double>::quiet_NaN();
    CHECK(found(health, row) == 0);
    CHECK(std::isnan(health.over_filling()));
    row.over_filling = 0.04;
    CHECK(found(health, row) == 0);
    row.over_filling = 0.07;
    const auto first = health.observe(row, 10, rounding);
    REQUIRE(first.size() == 1);
    CHECK(first[0].name() == "filling");
    CHECK(first[0].message().find("7 % of the volume") != std::string::npos);
    RunHealth<2> again;
    REQUIRE(again.restore(health.stored()));
    row.over_filling = 0.06;
    CHECK(found(again, row) == 0);
    CHECK(again.over_filling() == 0.07);
}

TEST_CASE("a restarted run goes on with what was warned of") {
    RunHealth<2> health, again;
    found(health, row_of(1, -1.5, 0.8));
    REQUIRE(again.restore(health.stored()));
    CHECK(again.warnings().size() == 1);
    CHECK(again.warnings()[0].message() == health.warnings()[0].message());
    CHECK(found(again, row_of(2, -1.5, 0.9)) == 1);  // energy: the row before counts
    CHECK(again.warnings()[1].problem == HealthProblem::energy);
    RunHealth<2> third;
    REQUIRE(third.restore(again.stored()));
    CHECK(found(third, row_of(3, -3, 2)) == 0);
}

TEST_CASE("what no run has stored is refused") {
    RunHealth<2> health;
    CHECK_FALSE(health.restore({1}));
    CHECK_FALSE(health.restore({1, 0, -1, 7, 1, 1, 1, 1, 1}));
    CHECK_FALSE(health.restore({1, 0, -1, 0, 1}));
    CHECK_FALSE(health.restore({std::numeric_limits<double>::quiet_NaN(), 0, -1}));
    CHECK(health.restore({1, 0, -1}));
}

TEST_CASE("a particle with a thousandth or a thousand times of its volume ends a run") {
    TimeSeriesRow<2> row;
    row.particles = 3;
    for (const auto& [least, most, lost] :
         {std::tuple{1e-3, 1e3, false}, {9e-4, 1.0, true}, {1.0, 1.1e3, true}, {7.6e-126, 1e125, true}}) {
        CAPTURE(least);
        row.totals.min_J = least, row.totals.max_J = most;
        CHECK(RunHealth<2>::lost_volume_in(row).empty() == !lost);
    }
    row.totals.min_J = std::nan("");
    CHECK(!RunHealth<2>::lost_volume_in(row).empty());
    row.particles = 0;  // all have left
    CHECK(RunHealth<2>::lost_volume_in(row).empty());
}

TEST_CASE("a volume that is no number is not lost among others, in any order") {
    const double none = std::nan("");
    for (const auto& order : {std::array{1.0, none, 2.0}, {none, 1.0, 2.0}, {1.0, 2.0, none}}) {
        TimeSeriesRow<2> row;
        row.particles = 3;
        for (const double J : order) {
            Totals<2> one;
            one.min_J = one.max_J = one.stretch.value = J, one.stretch.x = {J > 1 ? 3.0 : 1.0, 0};
            row.totals.widen(one);
        }
        CHECK(std::isnan(row.totals.min_J));
        CHECK(std::isnan(row.totals.max_J));
        CHECK(std::isnan(row.totals.stretch.value));
        CHECK(!RunHealth<2>::lost_volume_in(row).empty());
    }
}
