#include <doctest/doctest.h>

#include <cmath>

#include "replay/time_model.hpp"

using namespace moraine;

namespace {

constexpr CostModel prior{130000, 0, 8000000};

using Ranks = std::vector<std::pair<double, double>>;  // particles and blocks of each

/// Steps of ranks that compute as told, exchange for `e` per particle, wait for the slowest, and end `more` seconds
/// later. `factors`: factors on computing times.
ModelFit::Interval steps_of(const Ranks& ranks, double a, double d, double e, double more = 0,
                            std::vector<double> factors = {}) {
    ModelFit::Interval interval;
    interval.steps = 50;
    factors.resize(ranks.size(), 1);
    double longest = 0, slowest = 0, sum = 0;
    for (std::size_t r = 0; r < ranks.size(); ++r) {
        const double computing = factors[r] * (a * ranks[r].first + d * ranks[r].second);
        longest = std::max(longest, computing + e * ranks[r].first);
        slowest = std::max(slowest, computing);
        sum += computing;
        interval.ranks.push_back({ranks[r].first, ranks[r].second, computing, 0});
    }
    for (ModelFit::Sample& s : interval.ranks) s.exchange = longest + more - s.computing;
    interval.lost = slowest - sum / static_cast<double>(ranks.size());
    return interval;
}

/// Of a time: Approx alone would compare these small numbers with 1.
double ratio(double found, double expected) {
    return found / expected;
}

}  // namespace

TEST_CASE("costs of particles and blocks are found again where they vary") {
    ModelFit fit;
    for (const double check : {1e-3, 9e-3, 2e-3}) {
        fit.add(steps_of({{1000, 10}, {1100, 100}, {900, 4}}, 2e-7, 3e-6, 5e-8));
        ModelFit::Interval other = steps_of({{100, 30}, {1200, 10}, {300, 4}}, 2e-7, 3e-6, 5e-8);
        other.check = check;
        fit.add(other);
    }
    const TimeModel m = fit.model(prior);
    CHECK(ratio(m.particle, 2e-7) == doctest::Approx(1).epsilon(0.03));
    CHECK(ratio(m.block, 3e-6) == doctest::Approx(1).epsilon(0.1));
    CHECK(ratio(m.exchange, 5e-8) == doctest::Approx(1).epsilon(0.1));
    CHECK(m.timing_noise < 0.02);
}

TEST_CASE("an imbalance check costs the median of all") {
    ModelFit fit;
    for (const double check : {1e-3, 9e-3, 2e-3}) {
        ModelFit::Interval interval = steps_of({{1000, 10}}, 2e-7, 0, 0);
        interval.check = check;
        fit.add(interval);
    }
    CHECK(fit.model(prior).check == 2e-3);
}

TEST_CASE("where particles and blocks cannot be told apart their ratio is the cost model's, and the step is right") {
    ModelFit fit;
    for (int k = 0; k < 3; ++k) fit.add(steps_of({{1000, 20}, {1000, 20}}, 2e-7, 0, 1e-7));
    const TimeModel m = fit.model(prior);
    CHECK(m.block / m.particle == doctest::Approx(8000000.0 / 130000));
    CHECK(ratio(m.computing(1000, 20), 2e-4) == doctest::Approx(1));
    CHECK(ratio(m.exchange, 1e-7) == doctest::Approx(1));
    CHECK(m.timing_noise == 0);
}

TEST_CASE("waiting for others is no exchange: an idle rank does not make the busy one slower") {
    ModelFit fit;
    for (int k = 0; k < 8; ++k)
        fit.add(steps_of({{1000, 20}, {1000, 20}}, 2e-7, 0, 1e-8, 0, {k % 2 ? 1.2 : 0.8, k % 2 ? 0.8 : 1.2}));
    const TimeModel m = fit.model(prior);
    const std::vector<std::int64_t> alone{2000, 0}, its_blocks{40, 0}, both{1000, 1000}, blocks{20, 20};
    CHECK(ratio(m.exchange, 1e-8) == doctest::Approx(1));
    CHECK(m.timing_noise ==
          doctest::Approx(0.2 * 1.7725).epsilon(0.015));  // of two, the slower is s / sqrt(pi) above the mean
    CHECK(ratio(m.slowest(both, blocks) + m.waiting(both, blocks), 2.5e-4) == doctest::Approx(1).epsilon(0.01));
    CHECK(ratio(m.slowest(alone, its_blocks) + m.waiting(alone, its_blocks), 4.2e-4) ==
          doctest::Approx(1).epsilon(0.001));
}

TEST_CASE("what a step takes beyond computing and exchanges is the same for all steps") {
    ModelFit fit;
    fit.add(steps_of({{1000, 20}}, 2e-7, 0, 1e-8));
    fit.add(steps_of({{1000, 20}}, 2e-7, 0, 1e-8, 4e-5));
    const TimeModel m = fit.model(prior);
    CHECK(ratio(m.exchange, 1e-8) == doctest::Approx(1));
    CHECK(ratio(m.constant, 2e-5) == doctest::Approx(1));
}

TEST_CASE("the times of another run count as well") {
    ModelFit one, other;
    one.add(steps_of({{1000, 20}}, 2e-7, 0, 0));
    other.add(steps_of({{1000, 20}}, 4e-7, 0, 0));
    one.add(other);
    CHECK(ratio(one.model(prior).computing(1000, 20), 3e-4) == doctest::Approx(1));
}

TEST_CASE(
    "migrations are as slow as imbalance checks with one took beyond the others, and as reckoned where nothing moved") {
    ModelFit fit;
    const auto check = [&](double took, double moves) {
        ModelFit::Interval interval = steps_of({{1000, 10}}, 2e-7, 0, 0);
        interval.check = took, interval.moves = moves;
        fit.add(interval);
    };
    for (int k = 0; k < 7; ++k) check(1e-3, 0);
    CHECK(fit.model(prior).moves_slower == 1);
    check(6e-3, 20e-3);
    check(2e-3, 4e-3);
    CHECK(fit.model(prior).moves_slower == doctest::Approx((5e-3 + 1e-3) / 24e-3));
}

TEST_CASE("the largest of n equal normal variables is as far above their mean as tables say") {
    for (const auto& [n, deviations] : {std::pair{2, 0.56419}, {4, 1.02938}, {16, 1.76599}, {1000, 3.24144}}) {
        const std::vector<double> means(static_cast<std::size_t>(n), 3.0);
        CHECK(expected_maximum(means, 0.1) == doctest::Approx(3 * (1 + 0.1 * deviations)).epsilon(0.0005));
        CHECK(expected_maximum(means, 0) == 3);
    }
    CHECK(expected_maximum(std::vector<double>{3, 0, 0.1}, 0.2) == doctest::Approx(3).epsilon(0.0005));
    CHECK(expected_maximum({}, 0.2) == 0);
}

TEST_CASE("sending costs latency and bytes of the busiest rank in each exchange, one rank sends nothing") {
    TimeModel m;
    m.network = {1e-6, 1e9};
    HaloForecast halo;
    halo.neighbours_max = 5;
    halo.busiest_bytes = 3000;
    CHECK(ratio(m.sending(halo, 16, 2), 2 * (5e-6 + 3e-6) + 4e-6) == doctest::Approx(1));
    CHECK(m.sending(halo, 1, 2) == 0);
}

TEST_CASE("within a host messages have a latency and a bandwidth of their own") {
    TimeModel m;
    m.network = {1e-5, 1e8};
    m.within = {1e-6, 1e9};
    m.ranks_per_host = 4;
    HaloForecast halo;
    halo.sent.resize(16);
    halo.sent[3] = {3, 1, 2000, 100};  // most messages by time: 13e-6
    halo.sent[7] = {0, 1, 0, 500};     // most bytes by time: 5e-6
    CHECK(ratio(m.sending(halo, 16, 2), 2 * (13e-6 + 5e-6) + 2e-6 + 2e-5) == doctest::Approx(1));
    CHECK(m.sending(halo, 1, 2) == 0);
    halo.sent = {{2, 0, 1000, 0}, {1, 0, 3000, 0}, {}};
    CHECK(ratio(m.sending(halo, 3, 1), 2e-6 + 3e-6 + 1e-6 * std::log2(3)) == doctest::Approx(1));  // on one host
}

TEST_CASE("hosts whose network is that between ranks of one cost what a model without hosts says") {
    TimeModel one, two;
    one.network = two.network = two.within = {3e-6, 2e9};
    two.ranks_per_host = 2;
    HaloForecast halo;
    halo.sent = {{1, 3, 700, 300}, {0, 2, 0, 5000}, {1, 1, 40, 60}, {1, 0, 900, 0},
                 {0, 0, 0, 0},     {0, 0, 0, 0},    {0, 0, 0, 0},   {0, 0, 0, 0}};
    halo.neighbours_max = 4;
    halo.busiest_bytes = 5000;
    CHECK(ratio(two.sending(halo, 8, 3), one.sending(halo, 8, 3)) == doctest::Approx(1));
}
