#include <doctest/doctest.h>

#include <algorithm>

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

TEST_CASE("where a rank cannot hold its part by weight, the cut is the most even that all can hold; else all stays") {
    const std::vector<std::int64_t> heavy{70, 1, 1, 1, 1, 1, 1, 1};
    const std::vector<BlockLoad> blocks = blocks_of(tens, heavy);
    CHECK(held_by(check(blocks, 70), blocks, 0) == 70);
    for (const std::int64_t most : {60, 50, 40}) {  // by particles it would always be 40
        CAPTURE(most);
        const ImbalanceCheckResult fits = check(blocks, most + 9, Trigger::every);
        REQUIRE(fits.owners.size() == 8);
        CHECK(held_by(fits, blocks, 1) == 80 - most);
    }
    const ImbalanceCheckResult none = check(blocks, 39, Trigger::every);
    CHECK(none.owners.empty());
    CHECK(none.found.reason == "memory");
}

TEST_CASE("where the memory of ranks has no say, not a block goes elsewhere than without") {
    const std::vector<BlockLoad> blocks = blocks_of({10, 3, 9, 1, 10, 40, 2, 5}, {70, 1, 7, 1, 30, 1, 1, 9});
    const ImbalanceCheckResult plenty = check(blocks, 1000, Trigger::every);
    REQUIRE(plenty.owners.size() == 8);
    const std::int64_t most = std::max(held_by(plenty, blocks, 0), held_by(plenty, blocks, 1));
    CHECK(check(blocks, most, Trigger::every).owners == plenty.owners);
    CHECK(check(blocks, most - 1, Trigger::every).owners != plenty.owners);
}

TEST_CASE("a chain that has no cut that fits is not cut again by particles") {
    const std::vector<BlockLoad> blocks = blocks_of(tens, tens);
    struct Chain final : Partitioner {
        mutable int cuts = 0;
        const char* name() const override { return "chain"; }
        std::vector<std::int32_t> owners(std::span<const BlockLoad> all, std::int64_t) const override {
            ++cuts;
            return std::vector<std::int32_t>(all.size(), 0);
        }
        std::optional<std::vector<Option>> options_within(std::span<const BlockLoad>, std::int64_t) const override {
            return std::vector<Option>{};
        }
    } partitioner;
    BalanceSpec spec;
    spec.trigger = Trigger::every;
    ImbalanceCheckInput input;
    input.most = 60;
    const RepartitionTrigger trigger(spec, partitioner);
    CHECK(check_imbalance(blocks, input, 2, partitioner, trigger).found.reason == "memory");
    CHECK(partitioner.cuts == 1);
}

TEST_CASE("a partitioner that knows nothing of memory is asked for parts by particles") {
    const std::vector<BlockLoad> blocks = blocks_of(tens, {70, 1, 1, 1, 1, 1, 1, 1});
    struct ByWeight final : Partitioner {
        const char* name() const override { return "by weight"; }
        std::vector<std::int32_t> owners(std::span<const BlockLoad> all, std::int64_t) const override {
            return all[0].weight > 10 ? std::vector<std::int32_t>{0, 1, 1, 1, 1, 1, 1, 1}
                                      : std::vector<std::int32_t>{0, 0, 0, 0, 1, 1, 1, 1};
        }
    } partitioner;
    BalanceSpec spec;
    spec.trigger = Trigger::every;
    ImbalanceCheckInput input;
    input.most = 60;
    const ImbalanceCheckResult found =
        check_imbalance(blocks, input, 2, partitioner, RepartitionTrigger(spec, partitioner));
    REQUIRE(found.owners.size() == 8);
    CHECK(held_by(found, blocks, 1) == 40);
}
