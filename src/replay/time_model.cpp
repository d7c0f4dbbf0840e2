#include "replay/time_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace moraine {
namespace {

constexpr double most_timing_noise = 1;

double normal_below(double x) {
    return 0.5 * std::erfc(-x * M_SQRT1_2);
}

std::vector<double> busy_times(const TimeModel& m, const ModelFit::Interval& interval, bool with_exchange) {
    std::vector<double> times;
    for (const ModelFit::Sample& s : interval.ranks)
        times.push_back(with_exchange ? m.busy(s.particles, s.blocks) : m.computing(s.particles, s.blocks));
    return times;
}

double mean_computing(const ModelFit::Interval& interval) {
    double sum = 0;
    for (const ModelFit::Sample& s : interval.ranks) sum += s.computing;
    return sum / static_cast<double>(interval.ranks.size());
}

/// The value that so much of all are below; 0 of none.
double nth_of(std::vector<double> values, double part) {
    if (values.empty()) return 0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size()));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

}  // namespace

double expected_maximum(std::span<const double> means, double spread) {
    const double top = means.empty() ? 0 : *std::max_element(means.begin(), means.end());
    if (spread <= 0 || top <= 0) return top;
    // E = low + integral of 1 - F from there, F the product of the distributions; below -3 deviations F is nothing.
    constexpr int points = 48;
    const double low = top * (1 - 3 * spread), width = 9 * spread * top / points;
    double sum = 0;
    for (int k = 0; k < points; ++k) {
        const double x = low + (k + 0.5) * width;
        double below = 1;
        for (const double mean : means) {
            if (mean <= 0 || x > mean * (1 + 6 * spread)) continue;
            below *= normal_below((x - mean) / (spread * mean));
            if (below < 1e-9) break;
        }
        sum += 1 - below;
    }
    return low + width * sum;
}

double TimeModel::slowest(std::span<const std::int64_t> particles, std::span<const std::int64_t> blocks) const {
    double most = 0;
    for (std::size_t r = 0; r < particles.size(); ++r)
        most = std::max(most, busy(static_cast<double>(particles[r]), static_cast<double>(blocks[r])));
    return most;
}

double TimeModel::waiting(std::span<const std::int64_t> particles, std::span<const std::int64_t> blocks) const {
    std::vector<double> times;
    for (std::size_t r = 0; r < particles.size(); ++r)
        times.push_back(busy(static_cast<double>(particles[r]), static_cast<double>(blocks[r])));
    return times.size() < 2 ? 0 : std::max(0.0, expected_maximum(times, timing_noise) - slowest(particles, blocks));
}

double TimeModel::sending(const HaloForecast& halo, int ranks, double exchanges) const {
    if (ranks == 1) return 0;
    if (ranks_per_host > 0) return sending_by_hosts(halo, ranks, exchanges);
    return exchanges *
               (network.latency * halo.neighbours_max + static_cast<double>(halo.busiest_bytes) / network.bandwidth) +
           network.latency * std::log2(ranks);
}

double TimeModel::sending_by_hosts(const HaloForecast& halo, int ranks, double exchanges) const {
    double waits = 0, bytes = 0;
    for (const HaloForecast::Sent& s : halo.sent) {
        waits = std::max(waits, within.latency * s.neighbours_within + network.latency * s.neighbours_between);
        bytes = std::max(bytes, static_cast<double>(s.bytes_within) / within.bandwidth +
                                    static_cast<double>(s.bytes_between) / network.bandwidth);
    }
    const int here = std::min(ranks, ranks_per_host), hosts = (ranks + ranks_per_host - 1) / ranks_per_host;
    return exchanges * (waits + bytes) + within.latency * std::log2(here) + network.latency * std::log2(hosts);
}

void ModelFit::add(const ModelFit& other) {
    intervals_.insert(intervals_.end(), other.intervals_.begin(), other.intervals_.end());
}

void ModelFit::fit_costs(const CostModel& prior, TimeModel& m) const {
    double nn = 0, nb = 0, bb = 0, nt = 0, bt = 0;  // normal equations
    for (const Interval& interval : intervals_)
        for (const Sample& s : interval.ranks) {
            nn += interval.steps * s.particles * s.particles;
            nb += interval.steps * s.particles * s.blocks;
            bb += interval.steps * s.blocks * s.blocks;
            nt += interval.steps * s.particles * s.computing;
            bt += interval.steps * s.blocks * s.computing;
        }
    // The prior's ratio, scaled to fit; then the fit with a pull towards it.
    const auto a = static_cast<double>(prior.a), d = static_cast<double>(prior.d);
    const double modelled = a * a * nn + 2 * a * d * nb + d * d * bb;
    const double scale = modelled > 0 ? (a * nt + d * bt) / modelled : 0;
    constexpr double pull = 0.01;
    nt += pull * nn * scale * a, bt += pull * bb * scale * d;
    nn *= 1 + pull, bb *= 1 + pull;
    const double determinant = nn * bb - nb * nb;
    if (determinant > 0) {
        m.particle = (nt * bb - bt * nb) / determinant;
        m.block = (nn * bt - nb * nt) / determinant;
    }
    if (m.particle <= 0 || m.block < 0) m.particle = scale * a, m.block = scale * d;
}

/// Per particle, of ranks with at least half of the mean: the others wait, whatever they hold. Of all intervals the
/// lowest tenth: in the others all ranks wait in turn.
double ModelFit::least_exchange() const {
    std::vector<double> all;
    for (const Interval& interval : intervals_) {
        double total = 0, least = std::numeric_limits<double>::infinity();
        for (const Sample& s : interval.ranks) total += s.particles;
        for (const Sample& s : interval.ranks)
            if (s.particles > 0 && 2 * s.particles * static_cast<double>(interval.ranks.size()) >= total)
                least = std::min(least, std::max(0.0, s.exchange - interval.sending) / s.particles);
        if (total > 0) all.push_back(least);
    }
    return nth_of(std::move(all), 0.1);
}

/// With which the expected slowest ranks take as long as those of the run: least squares over intervals, with the slope
/// at a small timing noise. Where one rank has far the most to do timing noise does nothing, and the pull towards none
/// keeps an error of the costs from being taken for timing noise.
double ModelFit::timing_noise_of(const TimeModel& m) const {
    struct Measured {
        std::vector<double> times;
        double slowest, weight;
    };
    constexpr double small = 0.1, pull = 0.003;  // 1 % of the square of what timing noise does to two equal ranks
    std::vector<Measured> all;
    double steps = 0;
    for (const Interval& interval : intervals_) {
        std::vector<double> times = busy_times(m, interval, false);
        const double top = expected_maximum(times, 0);
        if (times.size() < 2 || top <= 0) continue;
        const double slope = (expected_maximum(times, small) / top - 1) / small;
        all.push_back({std::move(times), mean_computing(interval) + interval.lost, interval.steps * slope / top});
        steps += interval.steps;
    }
    const auto surplus = [&](double spread) {
        double sum = pull * steps * spread;
        for (const Measured& k : all) sum += k.weight * (expected_maximum(k.times, spread) - k.slowest);
        return sum;
    };
    double low = 0, high = most_timing_noise;
    if (surplus(low) >= 0) return 0;
    for (int k = 0; k < 30; ++k) {
        const double middle = (low + high) / 2;
        (surplus(middle) < 0 ? low : high) = middle;
    }
    return low;
}

double ModelFit::remainder(const TimeModel& m) const {
    double seconds = 0, steps = 0;
    for (const Interval& interval : intervals_) {
        double step = 0;
        for (const Sample& s : interval.ranks) step = std::max(step, s.computing + s.exchange);
        const double spread = interval.ranks.size() > 1 ? m.timing_noise : 0;
        seconds += interval.steps * (step - interval.sending - expected_maximum(busy_times(m, interval, true), spread));
        steps += interval.steps;
    }
    return steps > 0 ? std::max(0.0, seconds / steps) : 0;
}

/// The median: imbalance checks with a migration are few.
double ModelFit::usual_check() const {
    std::vector<double> checks;
    for (const Interval& interval : intervals_) checks.push_back(interval.check);
    return nth_of(std::move(checks), 0.5);
}

/// 1 where nothing moved.
double ModelFit::moves_slower(const TimeModel& m) const {
    double took = 0, reckoned = 0;
    for (const Interval& interval : intervals_) {
        if (interval.moves <= 0) continue;
        took += std::max(0.0, interval.check - m.check);
        reckoned += interval.moves;
    }
    return reckoned > 0 ? took / reckoned : 1;
}

TimeModel ModelFit::model(const CostModel& prior) const {
    TimeModel m;
    fit_costs(prior, m);
    m.exchange = least_exchange();
    m.timing_noise = timing_noise_of(m);
    m.constant = remainder(m);
    m.check = usual_check();
    m.moves_slower = moves_slower(m);
    return m;
}

}  // namespace moraine
