#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "engine/lead_rule.hpp"

using namespace moraine;

namespace {

const LeadRule<2> rule{0, 0.5, 10, 4, {0, -9.81}};
const LeadClock<2> start{1, 0, {0, -9}, 0, 100};
const LeadReport calm{100, 0.25, false, false};

}  // namespace

TEST_CASE("dt is the reach over the signal, and times and integrals go on by it") {
    LeadClock<2> clock = start;
    REQUIRE(goes_on(rule, calm, clock));
    CHECK(clock.dt == 0.5 / 100);
    CHECK(clock.time == 1 + clock.dt);
    CHECK(clock.gravity_impulse[1] == -9 + -9.81 * clock.dt);
    CHECK(clock.steps == 99);
}

TEST_CASE("a dt that the scene says is taken whatever the signal is") {
    LeadRule<2> fixed = rule;
    fixed.dt = 0.125;
    LeadClock<2> clock = start;
    REQUIRE(goes_on(fixed, {0, 0, false, false}, clock));
    CHECK(clock.dt == 0.125);
}

TEST_CASE(
    "it ends with a fault, its steps, the time somebody looks at, the run, a signal that is none, a dt too small") {
    const auto ends = [](const LeadRule<2>& by, const LeadReport& last, LeadClock<2> clock) {
        const LeadClock<2> before = clock;
        const bool ended = !goes_on(by, last, clock);
        CHECK(clock.time == (ended ? before.time : clock.time));
        CHECK(clock.steps == (ended ? before.steps : before.steps - 1));
        return ended;
    };
    CHECK_FALSE(ends(rule, calm, start));
    CHECK(ends(rule, {100, 0.25, false, true}, start));
    LeadClock<2> clock = start;
    clock.steps = 0;
    CHECK(ends(rule, calm, clock));
    clock = start, clock.time = 4;
    CHECK(ends(rule, calm, clock));
    clock.time = std::nextafter(4.0, 0.0);
    CHECK_FALSE(ends(rule, calm, clock));
    LeadRule<2> late = rule;
    late.until = 20;
    clock.time = 10;
    CHECK(ends(late, calm, clock));
    CHECK(ends(rule, {0, 0.25, false, false}, start));
    CHECK(ends(rule, {std::numeric_limits<double>::quiet_NaN(), 0.25, false, false}, start));
    CHECK(ends(rule, {1e14, 0.25, false, false}, start));
}

TEST_CASE("it ends when the guard layer is used up, as an epoch's lifetime counts it") {
    LeadClock<2> clock = start;
    EpochLifetime epoch;
    epoch.step(false, 0);  // its tables are binned
    for (const bool inside : {true, true, false, true, true, true, true, true, true}) {
        epoch.step(inside, 0.25);
        CHECK(goes_on(rule, {100, 0.25, inside, false}, clock) == !epoch.is_used_up());
        CHECK(clock.in_guard_layer == epoch.in_guard_layer());
    }
    CHECK(epoch.is_used_up());
}
