#include <doctest/doctest.h>

#include "balance/cut.hpp"
#include "balance/measured_cost.hpp"
#include "balance/weight.hpp"

using namespace moraine;

namespace {

constexpr int blocks = 400, in_a_block = 100, steps = 200;
constexpr std::int64_t start = 100;  // [ps]

BlockWeight by_time(std::int64_t picoseconds) {
    BalanceSpec spec;
    spec.weight = "time";
    return {spec, {picoseconds, 0, 0}};
}

/// Paces of two ranks that own blocks up to `cut` and from there on; cost(block, cut): of a particle there [ps].
template <class Cost>
std::array<MeasuredCost, 2> measured(std::int64_t cut, const Cost& cost) {
    std::array<double, 2> seconds{};
    for (int b = 0; b < blocks; ++b) seconds[b >= cut] += 1e-12 * cost(b, cut) * in_a_block;
    std::array<MeasuredCost, 2> measured_cost;
    for (int step = 0; step < steps; ++step)
        for (int r = 0; r < 2; ++r)
            measured_cost[r].add({seconds[r], std::max(seconds[0], seconds[1]), seconds[0] + seconds[1],
                                  in_a_block * (r == 0 ? cut : blocks - cut), in_a_block * blocks});
    return measured_cost;
}

/// The cut after some repartitions, each by what the ranks took before it.
template <class Cost>
std::int64_t settled(const Cost& cost) {
    std::int64_t cut = blocks / 2;
    for (int round = 0; round < 12; ++round) {
        const std::array<MeasuredCost, 2> measured_cost = measured(cut, cost);
        std::vector<std::int64_t> weights;
        for (int b = 0; b < blocks; ++b)
            weights.push_back(by_time(measured_cost[b >= cut].picoseconds(start))(in_a_block, 64));
        cut = exact_cut(weights, 2)[1];
    }
    return cut;
}

}  // namespace

TEST_CASE("shares by time end at equal times: a slow processor, and a stretch that costs more") {
    // 240 blocks at 100 ps and 160 at 150 ps take equally long
    CHECK(settled([](int b, std::int64_t cut) { return b < cut ? 100.0 : 150.0; }) == 240);
    // the last 100 blocks cost three times as much: 300 of 600 units end at block 300. A block that moves has the cost
    // per particle of the whole share that it came from, so the last one may stay where it is
    CHECK(std::abs(settled([](int b, std::int64_t) { return b < 300 ? 100.0 : 300.0; }) - 300) <= 1);
}

TEST_CASE("all ranks see the same imbalance of time, and forget it") {
    std::array<MeasuredCost, 2> measured_cost = measured(100, [](int, std::int64_t) { return 100.0; });
    CHECK(measured_cost[0].load(2).imbalance() == doctest::Approx(1.5));
    CHECK(measured_cost[1].load(2).imbalance() == doctest::Approx(1.5));
    for (int step = 0; step < 512; ++step) measured_cost[0].add({1, 1, 2, 10, 20});  // what was before fades
    CHECK(measured_cost[0].load(2).imbalance() == doctest::Approx(1).epsilon(1e-3));
    measured_cost[0].forget();
    CHECK(measured_cost[0].load(2).imbalance() == 1);
    CHECK(measured_cost[0].picoseconds(start) == start);
    measured_cost[0].add({9, 9, 10, 10, 20});  // the step before the repartition
    CHECK(measured_cost[0].load(2).imbalance() == 1);
    measured_cost[0].add({3, 3, 4, 10, 20});
    CHECK(measured_cost[0].load(2).imbalance() == doctest::Approx(1.5));
}

TEST_CASE("a rank with hardly any particles has no measured cost of its own") {
    MeasuredCost measured_cost;
    measured_cost.add({1e-5, 1e-3, 1.01e-3, 1, 10000001});  // 10 us for one particle
    CHECK(measured_cost.picoseconds(start) == 202);         // twice the mean
    MeasuredCost idle;
    idle.add({0, 1e-3, 1e-3, 0, 10000000});
    CHECK(idle.picoseconds(start) == 100);
}

TEST_CASE("weights by time have what a block takes besides its particles") {
    BalanceSpec spec;
    spec.weight = "time";
    const BlockWeight device(spec, {80, 300, 0}), flat(spec, {80, 300, 0}, 16), host(spec, {130, 0, 8000});
    CHECK(device.with_blocks(512, 1) == 512 + 240);
    CHECK(flat.with_blocks(512, 2) == 512 + 2 * 60);
    CHECK(host.with_blocks(1000, 10) == 1000 + 610);
    CHECK(device(512, 0) == 80 * 752);
    BlockWeight measured = device;
    measured.set_model({100, 0, 0});
    CHECK(measured(512, 64) == 100 * 752);  // a cost per particle changes the scale alone
}

TEST_CASE("weights by time are whole picoseconds, and never nothing") {
    CHECK(by_time(125)(512, 64) == 64000);
    CHECK(by_time(125)(0, 0) == 1);
    CHECK(by_time(125).seconds() == 1e-12);
}
