#include <doctest/doctest.h>

#include "balance/load.hpp"
#include "balance/weight.hpp"
#include "core/data/error.hpp"

using namespace moraine;

TEST_CASE("a key says where its block is, in 2-D and 3-D") {
    CHECK(block_position({2, {9, 9, 1}}, Morton<2>::encode({-1, 7})) == Position{-1, 7, 0});
    CHECK(block_position({3, {9, 9, 9}}, Morton<3>::encode({3, -1, 8})) == Position{3, -1, 8});
}

TEST_CASE("imbalance is the maximum over the mean of all ranks, idle ones included") {
    const std::vector<BlockLoad> blocks{{1, 10, 100, 0}, {2, 20, 300, 1}, {3, 30, 500, -1}};
    const auto owners = present_owners(blocks);
    const LoadSummary weight = summary_of(loads_of_ranks(blocks, owners, 4));
    CHECK(weight.max == 300);
    CHECK(weight.total == 400);
    CHECK(weight.imbalance() == 3);
    CHECK(summary_of(loads_of_ranks(blocks, owners, 4, &BlockLoad::particles)).imbalance() ==
          doctest::Approx(20 * 4 / 30.0));
}

TEST_CASE("ranks without any load are balanced") {
    CHECK(LoadSummary{0, 0, 5}.imbalance() == 1);
}

TEST_CASE("loads beyond 32 and close to 63 bits keep their ratio") {
    CHECK(LoadSummary{INT64_MAX / 2, INT64_MAX, 16384}.imbalance() == doctest::Approx(8192));
}

TEST_CASE("a cost is rounded to whole nanoseconds from constants in picoseconds") {
    BalanceSpec spec;
    spec.weight = "cost";
    const BlockWeight device(spec, {125, 10, 2000});
    CHECK(device(512, 64) == 67);  // 64 + 0.64 + 2
    CHECK(device(0, 0) == 2);
    CHECK(BlockWeight(spec, {400, 0, 0})(1, 1) == 1);  // an occupied block is never free
    CHECK(BlockWeight(spec, {400000, 3000, 0})(5000000000, 64) == 2000000000192);
}

TEST_CASE("the plain weight counts particles") {
    CHECK(BlockWeight(BalanceSpec{}, {125, 10, 2000})(512, 64) == 512);
    CHECK(BlockWeight(BalanceSpec{}, {125, 10, 2000})(0, 0) == 0);
}

TEST_CASE("an unknown weight is refused") {
    BalanceSpec spec;
    spec.weight = "mass";
    CHECK_THROWS_WITH_AS(BlockWeight(spec, {1, 1, 1}),
                         "balance.weight = \"mass\" (no such weight). Use particles, cost or time?", InputError);
}
