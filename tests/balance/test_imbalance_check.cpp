#include <doctest/doctest.h>

#include "balance/imbalance_check.hpp"

using namespace moraine;

namespace {

Layout row_of_blocks() {
    return {2, {8, 1, 1}, {}, 3};
}

/// Eight blocks in a row, all held by rank 0 of two.
std::vector<BlockLoad> blocks_of(const std::vector<std::int64_t>& particles, const std::vector<std::int64_t>& weights) {
    std::vector<BlockLoad> blocks;
    for (std::size_t b = 0; b < particles.size(); ++b)
        blocks.push_back({Morton<2>::encode({static_cast<std::int32_t>(b), 0}), particles[b], weights[b], 0});
    return blocks;
}

ImbalanceCheckResult check(const std::vector<BlockLoad>& blocks, std::int64_t most, Trigger rule = Trigger::threshold) {
    BalanceSpec spec;
    spec.trigger = rule;
    const auto partitioner = make_partitioner(spec, row_of_blocks(), 2);
    ImbalanceCheckInput input;
    input.times.step = 50;
    input.most = most;
    input.unit = 1e-9;
    return check_imbalance(blocks, input, 2, *partitioner, RepartitionTrigger(spec, *partitioner));
}

const std::vector<std::int64_t> tens(8, 10);

std::int64_t held_by(const ImbalanceCheckResult& found, const std::vector<BlockLoad>& blocks, int rank) {
    std::int64_t sum = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b)
        if (found.owners[b] == rank) sum += blocks[b].particles;
    return sum;
}

}  // namespace

TEST_CASE("an imbalance check that finds one rank with all gives half to the other, and says why") {
    const std::vector<BlockLoad> blocks = blocks_of(tens, tens);
    const ImbalanceCheckResult found = check(blocks, 1000);
    REQUIRE(found.owners.size() == 8);
    CHECK(found.found.repartitioned);
    CHECK(found.found.reason == "threshold");
    CHECK(found.found.terms.step == 50);
    CHECK(found.found.terms.now.imbalance() == 2);
    CHECK(found.found.terms.plan.imbalance() == 1);
    CHECK(held_by(found, blocks, 0) == 40);
}

TEST_CASE("an imbalance check changes nothing where all is balanced, unless the trigger is every") {
    std::vector<BlockLoad> blocks = blocks_of(tens, tens);
    for (std::size_t b = 4; b < 8; ++b) blocks[b].owner = 1;
    const ImbalanceCheckResult found = check(blocks, 1000);
    CHECK(found.owners.empty());
    CHECK_FALSE(found.found.repartitioned);
    CHECK(found.found.reason == "balanced");
    CHECK(check(blocks, 1000, Trigger::every).owners.size() == 8);
}

TEST_CASE("where a rank cannot hold its part by weight, parts are by particles; where not even that, all stays") {
    const std::vector<std::int64_t> heavy{70, 1, 1, 1, 1, 1, 1, 1};
    const std::vector<BlockLoad> blocks = blocks_of(tens, heavy);
    CHECK(held_by(check(blocks, 70), blocks, 0) == 70);
    const ImbalanceCheckResult fits = check(blocks, 40, Trigger::every);
    REQUIRE(fits.owners.size() == 8);
    CHECK(held_by(fits, blocks, 1) == 40);
    const ImbalanceCheckResult none = check(blocks, 39, Trigger::every);
    CHECK(none.owners.empty());
    CHECK(none.found.reason == "memory");
}
