#include <doctest/doctest.h>

#include "balance/planner.hpp"

using namespace moraine;

namespace {

/// Four blocks of few and many particles; the weight, by which a cut is made, is the same for all.
const std::vector<BlockLoad> blocks{{1, 10, 5, 0}, {2, 10, 5, 0}, {3, 100, 5, 1}, {4, 120, 5, 1}};

}  // namespace

TEST_CASE("the fullest rank is counted in particles, whatever the weights") {
    CHECK(fullest(blocks, std::vector<std::int32_t>{0, 0, 1, 1}, 2) == 220);
    CHECK(fullest(blocks, std::vector<std::int32_t>{0, 0, 0, 1}, 2) == 120);
    CHECK(fullest(blocks, std::vector<std::int32_t>{0, 0, 0, 1}, 5) == 120);
}

TEST_CASE("options that a rank cannot hold are dropped, and the others stay in order") {
    const std::vector<Option> all{
        {PlanKind::natural, {0, 0, 1, 1}}, {PlanKind::relabelled, {0, 0, 0, 1}}, {PlanKind::least, {1, 1, 1, 0}}};
    const std::vector<Option> fit = that_fit(all, blocks, 2, 150);
    REQUIRE(fit.size() == 2);
    CHECK(fit[0].kind == PlanKind::relabelled);
    CHECK(fit[1].kind == PlanKind::least);
    CHECK(that_fit(all, blocks, 2, 119).empty());
    CHECK(that_fit(all, blocks, 2, 220).size() == 3);
}
