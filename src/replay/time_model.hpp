#pragma once
// What a step costs on any number of ranks, from what the steps of a run cost. A model: its times are predictions.
//
//   step = E[max over ranks of t_r (1 + s x_r)] + c + exchanges (latency k + bytes / bandwidth) + latency log2 P
//   t_r  = (a + e) n_r + d b_r;   look: a constant;   a migration: f times what the planner reckons (planner.hpp)
//
// n_r, b_r: particles and blocks of rank r; k: neighbours, bytes: sent, of the busiest. a and d are fitted to computing
// times by least squares with a pull (1 %) towards the ratio of the cost model: a run whose particles and blocks hardly
// vary cannot tell them apart. e is what binning and exchanges took of the rank that waited least.
// x_r is normal: equal loads do not take equal time, and s follows from what the slowest ranks took, step by step.
// f is what imbalance checks with a migration took beyond the median of all. c is what remains of a step. A run does
// not tell latency and bandwidth: they are the user's.

#include <cstdint>
#include <span>

#include "balance/planner.hpp"
#include "balance/weight.hpp"
#include "replay/halo_forecast.hpp"

namespace moraine {

struct Network {
    double latency = 2e-6;   ///< of a message [s]
    double bandwidth = 5e9;  ///< of a rank, out [byte/s]
};

/// Of the largest of independent normal variables with these means, not negative, and deviations `spread * mean`.
/// Not collective.
double expected_maximum(std::span<const double> means, double spread);

struct TimeModel {
    double particle = 0;              ///< a [s]
    double block = 0;                 ///< d [s]
    double exchange = 0;              ///< e [s]
    double timing_noise = 0;          ///< s
    double constant = 0;              ///< c [s]
    double check = 0;                 ///< [s]
    Network network;                  ///< between hosts, or between any ranks
    Network within;                   ///< within a host
    std::int32_t ranks_per_host = 0;  ///< 0: hosts are not told apart
    MoveModel moves = host_moves;     ///< what planners reckon with
    double moves_slower = 1;          ///< f

    double computing(double particles, double blocks) const { return particle * particles + block * blocks; }

    /// Of a rank, with what its exchanges cost besides the network: t_r [s per step].
    double busy(double particles, double blocks) const { return computing(particles, blocks) + exchange * particles; }
    /// Of the rank that has most to do [s per step].
    double slowest(std::span<const std::int64_t> particles, std::span<const std::int64_t> blocks) const;
    /// What timing noise adds to that [s per step].
    double waiting(std::span<const std::int64_t> particles, std::span<const std::int64_t> blocks) const;
    /// Of so many ranks; nothing where they are not told apart.
    HostOfRank hosts(int ranks) const { return ranks_per_host > 0 ? hosts_of(ranks, ranks_per_host) : HostOfRank{}; }
    /// exchanges: of the halo per step [-]. [s per step]
    double sending(const HaloForecast& halo, int ranks, double exchanges) const;

  private:
    /// Messages within hosts (w) and between them (b) have a latency and a bandwidth each; as above where both are
    /// alike:
    ///   exchanges (max over r of (l_w k_rw + l_b k_rb) + max over r of (bytes_rw / B_w + bytes_rb / B_b))
    ///     + l_w log2(ranks per host) + l_b log2(hosts)
    double sending_by_hosts(const HaloForecast& halo, int ranks, double exchanges) const;
};

/// Intervals of one run or several, from which a model follows.
class ModelFit {
  public:
    /// What a rank held, and its seconds per step: of computing, and of binning and exchanges, waiting included.
    struct Sample {
        double particles, blocks, computing, exchange;
    };

    struct Interval {
        std::vector<Sample> ranks;
        double steps = 0;
        double sending = 0;  ///< by the network model [s per step]
        double lost = 0;     ///< computing of the slowest rank less mean [s per step]
        double check = 0;    ///< balancing, of the rank that waited least [s]
        double moves = 0;    ///< the migration at its end, as planners reckon it [s]
    };

    /// Not collective.
    void add(Interval interval) { intervals_.push_back(std::move(interval)); }
    void add(const ModelFit& other);

    /// Without network and what planners reckon moves with. `prior`: the ratio of costs per particle and
    /// block. Not collective.
    TimeModel model(const CostModel& prior) const;

  private:
    void fit_costs(const CostModel& prior, TimeModel& m) const;
    double least_exchange() const;
    double timing_noise_of(const TimeModel& m) const;
    double remainder(const TimeModel& m) const;
    double usual_check() const;
    double moves_slower(const TimeModel& m) const;

    std::vector<Interval> intervals_;
};

}  // namespace moraine
