#include <doctest/doctest.h>

#include <vector>

#include "balance/calibration.hpp"

using namespace moraine;

namespace {

constexpr CostModel start{100, 50, 40000};  // [ps]

CostSample sample(const CostModel& truth, double particles, double cells, double blocks) {
    const double ps = static_cast<double>(truth.a) * particles + static_cast<double>(truth.c) * cells +
                      static_cast<double>(truth.d) * blocks;
    return {particles, cells, blocks, 1e-12 * ps};
}

/// Ranks with many particles in few blocks, few in many, and single cells.
std::vector<CostSample> mixed(const CostModel& truth) {
    return {sample(truth, 4e6, 5e5, 8e3), sample(truth, 1e6, 2e5, 4e4), sample(truth, 2e6, 1e6, 2e4)};
}

}  // namespace

TEST_CASE("without samples the model is the one given, and ranks without work tell nothing") {
    Calibration c(start);
    CHECK(c.model().a == start.a);
    c.add(std::vector<CostSample>{{0, 0, 0, 0}, {0, 0, 0, 1e-3}, {1e6, 1e5, 1e3, 0}});
    CHECK(c.model().a == start.a);
    CHECK(c.model().d == start.d);
}

TEST_CASE("a slower machine scales the model and keeps its proportions") {
    Calibration c(start);
    const CostModel slower{1000, 500, 400000};
    for (int k = 0; k < 5; ++k) c.add(mixed(slower));
    CHECK(c.model().a == doctest::Approx(1000).epsilon(0.01));
    CHECK(c.model().c == doctest::Approx(500).epsilon(0.01));
    CHECK(c.model().d == doctest::Approx(400000).epsilon(0.01));
}

TEST_CASE("ranks of one mix leave the proportions alone") {
    Calibration c(start);
    const CostModel truth{300, 50, 10000};
    for (int k = 0; k < 20; ++k)
        c.add(std::vector<CostSample>{sample(truth, 1e6, 1e5, 2e3), sample(truth, 2e6, 2e5, 4e3)});
    const double proportion = static_cast<double>(c.model().d) / static_cast<double>(c.model().a);
    CHECK(proportion == doctest::Approx(400).epsilon(0.05));
}

TEST_CASE("ranks of different mixes tell the costs apart") {
    Calibration c(start);
    const CostModel truth{60, 50, 120000};
    for (int k = 0; k < 30; ++k) c.add(mixed(truth));
    const CostModel found = c.model();
    for (const CostSample& s : mixed(truth)) {
        const double ps = static_cast<double>(found.a) * s.particles + static_cast<double>(found.c) * s.cells +
                          static_cast<double>(found.d) * s.blocks;
        CHECK(1e-12 * ps == doctest::Approx(s.seconds).epsilon(0.02));
    }
    CHECK(found.d > 2 * start.d);
}

TEST_CASE("a term keeps a tenth of its proportion, and one that is not in the model stays out of it") {
    Calibration c({100, 0, 40000});
    for (int k = 0; k < 30; ++k) c.add(mixed({100, 0, 0}));
    CHECK(c.model().c == 0);
    CHECK(c.model().d > 0);
    CHECK(c.model().d < 20000);
}

TEST_CASE("what was true long ago is forgotten") {
    Calibration c(start);
    for (int k = 0; k < 10; ++k) c.add(mixed(start));
    for (int k = 0; k < 30; ++k) c.add(mixed({200, 100, 80000}));
    CHECK(c.model().a == doctest::Approx(200).epsilon(0.01));
}
