#include <doctest/doctest.h>

#include <cmath>

#include "balance/planner.hpp"

using namespace moraine;
using Owners = std::vector<std::int32_t>;

namespace {

/// Two ranks, rank 0 with 60 of 100 particles.
const std::vector<BlockLoad> blocks{{0, 30, 30, 0}, {1, 20, 20, 0}, {2, 10, 10, 0}, {3, 40, 40, 1}};
const Owners balanced{0, 0, 1, 1};  // 50, moves 10
const Owners swapped{1, 1, 0, 0};   // 50, moves 50 and 40
const Owners nearly{0, 0, 0, 1};    // 60, moves nothing: as it is

std::vector<Option> options() {
    return {{PlanKind::natural, swapped}, {PlanKind::relabelled, balanced}, {PlanKind::least, nearly}};
}

/// A step takes 1 s per particle, a particle 1 s to move.
PlanCosts costs(double steps, bool may_keep = false) {
    PlanCosts c;
    c.step = 1;
    c.steps = steps;
    c.move = {5, 1};
    c.may_keep = may_keep;
    return c;
}

double seconds(const Plan& plan, PlanKind kind) {
    return plan.seconds[static_cast<std::size_t>(kind)];
}

}  // namespace

TEST_CASE("a plan costs the steps of its slowest rank, and its migration by the busiest rank") {
    const Plan plan = best_plan(options(), blocks, 2, costs(10));
    CHECK(seconds(plan, PlanKind::natural) == doctest::Approx(10 * 50 + 5 + 50));  // rank 0 sends 50
    CHECK(seconds(plan, PlanKind::relabelled) == doctest::Approx(10 * 50 + 5 + 10));
    CHECK(seconds(plan, PlanKind::least) == doctest::Approx(10 * 60));
    CHECK(std::isnan(seconds(plan, PlanKind::keep)));
    CHECK(plan.kind == PlanKind::relabelled);
    CHECK(plan.owners == balanced);
    CHECK(plan.load.max == 50);
    CHECK(plan.migration == 15);
}

TEST_CASE("a run that soon repartitions again takes the plan that moves less") {
    CHECK(best_plan(options(), blocks, 2, costs(1)).kind == PlanKind::least);
    CHECK(best_plan(options(), blocks, 2, costs(2)).kind == PlanKind::relabelled);
}

TEST_CASE("the present owners are kept where that is cheapest and the trigger leaves the choice") {
    std::vector<Option> two = options();
    two.pop_back();
    CHECK(best_plan(two, blocks, 2, costs(1)).kind == PlanKind::relabelled);
    const Plan plan = best_plan(two, blocks, 2, costs(1, true));
    CHECK(plan.kind == PlanKind::keep);
    CHECK(plan.owners == present_owners(blocks));
    CHECK(plan.migration == 0);
    CHECK(seconds(plan, PlanKind::keep) == 60);
    CHECK(best_plan(two, blocks, 2, costs(2, true)).kind == PlanKind::relabelled);
}

TEST_CASE("blocks that nobody holds cannot be kept, and cost nothing to move") {
    std::vector<BlockLoad> nobodys = blocks;
    for (BlockLoad& block : nobodys) block.owner = -1;
    const Plan plan = best_plan(options(), nobodys, 2, costs(1, true));
    CHECK(std::isnan(seconds(plan, PlanKind::keep)));
    CHECK(plan.kind == PlanKind::natural);  // of equals the first
    CHECK(plan.migration == 0);
}

TEST_CASE("plans have names for the records") {
    CHECK(std::string(name_of(PlanKind::keep)) == "keep");
    CHECK(std::string(name_of(PlanKind::least)) == "least migration");
}
