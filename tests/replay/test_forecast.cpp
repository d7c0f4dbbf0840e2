#include <doctest/doctest.h>

#include "balance/relabel.hpp"
#include "core/data/hash.hpp"
#include "replay/forecast.hpp"
#include "replay/optimum.hpp"

using namespace moraine;

namespace {

constexpr CostModel weights{100000, 0, 0};

TimeModel model() {
    TimeModel m;
    m.particle = 1e-5;
    m.block = 2e-6;
    return m;
}

Layout layout() {
    Layout l;
    l.dimensions = 2;
    l.blocks = {64, 64, 1};
    return l;
}

/// A heap that moves along x and changes its shape: looks of 50 steps.
std::vector<Interval> moving_heap(int intervals, std::uint64_t seed) {
    std::vector<Interval> all;
    for (int k = 0; k < intervals; ++k) {
        Interval interval;
        interval.step = 50 * k;
        for (std::int32_t x = k; x < 12 + 2 * k; ++x)
            for (std::int32_t y = 0; y < 4; ++y) {
                const Key key = Morton<2>::encode({x, y});
                interval.blocks.push_back(
                    {key, static_cast<std::int64_t>(1 + mix(seed + mix(key) + static_cast<unsigned>(k / 2)) % 90), 0,
                     -1});
            }
        std::sort(interval.blocks.begin(), interval.blocks.end(),
                  [](const BlockLoad& a, const BlockLoad& b) { return a.key < b.key; });
        all.push_back(interval);
    }
    return all;
}

std::vector<Carry> carries_of(const std::vector<Interval>& intervals) {
    std::vector<Carry> carries(1);
    for (std::size_t k = 1; k < intervals.size(); ++k)
        carries.push_back(carry_between(layout(), keys_of(intervals[k - 1].blocks), intervals[k].blocks));
    return carries;
}

ForecastResult forecast(const BalanceSpec& spec, std::vector<Interval> intervals, int ranks, bool relabelled = false,
                        const TimeModel& m = model()) {
    const Layout l = layout();
    const std::vector<Carry> carries = carries_of(intervals);
    Forecast f(spec, l, weights, ranks, m, relabelled);
    for (std::size_t k = 0; k < intervals.size(); ++k) {
        f.check(intervals[k], carries[k]);
        f.add_halo(HaloSurroundings(l, intervals[k].blocks), 40);
    }
    return f.result();
}

/// Seconds of repartitioning at just the imbalance checks of `mask` (bit k: look k), one after the other.
double seconds_of(unsigned mask, const std::vector<Interval>& intervals, const std::vector<Carry>& carries, int ranks,
                  const TimeModel& m) {
    const Layout l = layout();
    const auto partitioner = make_partitioner(BalanceSpec{}, l, ranks, m.hosts(ranks));
    std::vector<std::int32_t> owners;
    double seconds = 0, slowest = 0;
    const auto slowest_of = [&](const Interval& interval) {
        std::vector<std::int64_t> blocks(static_cast<std::size_t>(ranks), 0);
        for (std::int32_t o : owners) ++blocks[o];
        return m.slowest(loads_of_ranks(interval.blocks, owners, ranks, &BlockLoad::particles), blocks);
    };
    for (std::size_t k = 0; k < intervals.size(); ++k) {
        std::vector<BlockLoad> blocks = intervals[k].blocks;
        for (BlockLoad& b : blocks) b.weight = b.particles;
        if (k > 0) {
            owners = carries[k].owners(owners, intervals[k], l, *partitioner);
            seconds += 50 * (slowest + slowest_of(intervals[k])) / 2;
            for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].owner = owners[b];
        }
        if (k == 0 || mask >> k & 1u) {
            const std::vector<std::int32_t> next = partitioner->owners(blocks, 0);
            PlanCosts costs;
            costs.move = host_moves;
            if (k > 0) seconds += best_plan({{PlanKind::relabelled, next}}, blocks, ranks, costs).migration;
            owners = next;
        }
        slowest = slowest_of(intervals[k]);
    }
    return seconds;
}

}  // namespace

TEST_CASE("a block keeps its owner, a new one follows its first neighbour, an island the block before it") {
    const Layout l = layout();
    const auto at = [](std::int32_t x, std::int32_t y) { return Morton<2>::encode({x, y}); };
    Interval now;
    for (const Key key : {at(0, 0), at(1, 0), at(2, 0), at(3, 0), at(40, 40)}) now.blocks.push_back({key, 1, 1, -1});
    const Carry carry = carry_between(l, std::vector<Key>{at(0, 0), at(5, 5)}, now.blocks);
    const auto morton = make_partitioner(BalanceSpec{}, l, 9);
    CHECK(carry.owners(std::vector<std::int32_t>{7, 3}, now, l, *morton) == std::vector<std::int32_t>(5, 7));
    BalanceSpec spec;
    spec.partitioner = "slabs";
    const auto slabs = make_partitioner(spec, l, 64);
    CHECK(carry.owners(std::vector<std::int32_t>{0, 3}, now, l, *slabs) == std::vector<std::int32_t>{0, 1, 2, 3, 40});
}

TEST_CASE("never keeps the first cut, every repartitions at each imbalance check but the first, threshold in between") {
    BalanceSpec spec;
    spec.trigger = Trigger::never;
    const ForecastResult never = forecast(spec, moving_heap(9, 1), 4);
    spec.trigger = Trigger::every;
    const ForecastResult every = forecast(spec, moving_heap(9, 1), 4);
    spec.trigger = Trigger::threshold;
    const ForecastResult threshold = forecast(spec, moving_heap(9, 1), 4);
    CHECK(never.repartitions == 0);
    CHECK(never.migrated_particles == 0);
    CHECK(every.repartitions == 8);
    CHECK(never.steps == 400);
    CHECK(every.imbalance_mean() < never.imbalance_mean());
    CHECK(threshold.imbalance_mean() <= never.imbalance_mean());
    CHECK(threshold.repartitions <= 8);
}

TEST_CASE("one rank is balanced and sends nothing; its time is the model's") {
    const std::vector<Interval> intervals = moving_heap(3, 5);
    const ForecastResult r = forecast(BalanceSpec{}, intervals, 1);
    double expected = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        double n = 0;
        for (const BlockLoad& b : intervals[k].blocks) n += static_cast<double>(b.particles);
        expected += (k == 1 ? 50 : 25) * (1e-5 * n + 2e-6 * static_cast<double>(intervals[k].blocks.size()));
    }
    CHECK(r.imbalance_mean() == 1);
    CHECK(r.bytes == 0);
    CHECK(r.computing == doctest::Approx(expected));
    CHECK(r.computing == doctest::Approx(r.ideal));
}

TEST_CASE(
    "the offline optimum is the least of all subsets of imbalance checks to a thousandth, and no trigger beats it") {
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
        CAPTURE(seed);
        const int ranks = seed < 12 ? 2 + static_cast<int>(seed % 4) : 4 + 2 * static_cast<int>(seed % 2);
        const std::vector<Interval> intervals = moving_heap(7, seed);
        const std::vector<Carry> carries = carries_of(intervals);
        const Layout l = layout();
        TimeModel m = model();
        if (seed >= 12) m.ranks_per_host = 2;
        const Optimum best = offline_optimum(BalanceSpec{}, l, weights, ranks, m, intervals, carries);
        double least = 1e300;
        for (unsigned mask = 0; mask < 64; mask += 2)
            least = std::min(least, seconds_of(mask, intervals, carries, ranks, m));
        CHECK(best.seconds == doctest::Approx(least).epsilon(1e-3));  // ties of the greedy relabelling
        for (const Trigger trigger : {Trigger::never, Trigger::every, Trigger::threshold, Trigger::planned}) {
            BalanceSpec spec;
            spec.trigger = trigger;
            const ForecastResult r = forecast(spec, intervals, ranks, true, m);
            CHECK(r.computing + r.migration >= best.seconds * (1 - 1e-3));
        }
    }
}

TEST_CASE("hosts change who is called what and what crosses, and neither loads nor the halo") {
    BalanceSpec spec;
    spec.trigger = Trigger::every;
    const ForecastResult plain = forecast(spec, moving_heap(9, 3), 8, true);
    CHECK(plain.tiles_between == 0);  // nobody asked
    double before = 0;
    for (const int each : {8, 4, 2, 1}) {
        TimeModel m = model();
        m.ranks_per_host = each;
        m.within = m.network;
        const ForecastResult found = forecast(spec, moving_heap(9, 3), 8, true, m);
        CHECK(found.tiles == plain.tiles);
        CHECK(found.imbalance_sum == plain.imbalance_sum);
        CHECK(found.sending == doctest::Approx(plain.sending).epsilon(1e-9));
        CHECK((found.tiles_between == 0) == (each == 8));
        CHECK((found.tiles_between == found.tiles) == (each == 1));
        CHECK(found.tiles_between >= before);
        before = found.tiles_between;
        m.within = {m.network.latency / 10, m.network.bandwidth * 10};
        const ForecastResult faster = forecast(spec, moving_heap(9, 3), 8, true, m);
        CHECK((faster.sending < found.sending) == (each > 1));
    }
}
