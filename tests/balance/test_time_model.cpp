#include <doctest/doctest.h>

#include "balance/time_model.hpp"

using namespace moraine;

namespace {

constexpr CostModel prior{130000, 0, 8000000};

/// Steps of ranks that compute as told and wait for the slowest, and `more` seconds per particle of the heaviest.
void feed(ModelFit& calibration, const std::vector<std::pair<double, double>>& ranks, double a, double d, double more,
          double look) {
    double longest = 0, heaviest = 0;
    for (const auto& [n, b] : ranks) longest = std::max(longest, a * n + d * b), heaviest = std::max(heaviest, n);
    std::vector<ModelFit::Sample> samples;
    for (const auto& [n, b] : ranks) samples.push_back({n, b, a * n + d * b, longest + more * heaviest});
    calibration.add(samples, 50, 0, look);
}

}  // namespace

TEST_CASE("costs of particles and blocks are found again where they vary") {
    ModelFit calibration;
    feed(calibration, {{1000, 10}, {1100, 100}, {900, 4}}, 2e-7, 3e-6, 5e-8, 1e-3);
    feed(calibration, {{100, 30}, {1200, 10}, {300, 4}}, 2e-7, 3e-6, 5e-8, 9e-3);
    feed(calibration, {{100, 30}, {1200, 10}, {300, 4}}, 2e-7, 3e-6, 5e-8, 2e-3);
    const TimeModel m = calibration.model(prior);
    CHECK(m.particle == doctest::Approx(2e-7).epsilon(0.03));
    CHECK(m.block == doctest::Approx(3e-6).epsilon(0.1));
    CHECK(m.exchange == doctest::Approx(5e-8).epsilon(0.1));
    CHECK(m.look == 2e-3);
}

TEST_CASE("where particles and blocks cannot be told apart their ratio is the cost model's, and the step is right") {
    ModelFit calibration;
    for (int k = 0; k < 3; ++k) feed(calibration, {{1000, 20}, {1000, 20}}, 2e-7, 0, 1e-7, 0);
    const TimeModel m = calibration.model(prior);
    CHECK(m.block / m.particle == doctest::Approx(8000000.0 / 130000));
    CHECK(m.computing(1000, 20) == doctest::Approx(2e-4));
    CHECK(m.exchange == doctest::Approx(1e-7));
}

TEST_CASE("sending costs latency and bytes of the busiest rank in each round, one rank sends nothing") {
    TimeModel m;
    m.rounds = 2;
    m.wire = {1e-6, 1e9};
    HaloForecast halo;
    halo.neighbours_max = 5;
    halo.busiest_bytes = 3000;
    CHECK(m.sending(halo, 16) == doctest::Approx(2 * (5e-6 + 3e-6) + 4e-6));
    CHECK(m.sending(halo, 1) == 0);
}
