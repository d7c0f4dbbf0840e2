#pragma once
// What a step costs on any number of ranks, from what the steps of one run cost. A model: its times are predictions.
//
//   step     = max over ranks of (a + e) n_r + d b_r  +  rounds (latency k + bytes / bandwidth) + latency log2 P
//   look     = a constant; a migration: planner.hpp
//
// n_r, b_r: particles and blocks of rank r; k: neighbours, bytes: sent, of the busiest rank. a and d are fitted to
// computing times of all ranks and intervals, by least squares with a pull (1 %) towards the ratio of the cost model,
// because a run whose particles and blocks hardly vary cannot tell them apart. e is what steps took
// beyond that and the wire, per particle of the heaviest rank: filing, packing, and the machine's unrest. Latency and
// bandwidth are not measured by a run: they are the user's.

#include <cstdint>
#include <span>

#include "balance/halo_forecast.hpp"
#include "balance/planner.hpp"
#include "balance/weight.hpp"

namespace moraine {

struct Wire {
    double latency = 2e-6;   ///< of a message [s]
    double bandwidth = 5e9;  ///< of a rank, out [byte/s]
};

struct TimeModel {
    double particle = 0;  ///< a [s]
    double block = 0;     ///< d [s]
    double exchange = 0;  ///< e [s]
    double look = 0;      ///< [s]
    int rounds = 1;
    Wire wire;
    MoveModel moves = host_moves;

    double computing(double particles, double blocks) const { return particle * particles + block * blocks; }

    /// Of the slowest rank, with what its exchanges cost besides the wire [s per step].
    double slowest(std::span<const std::int64_t> particles, std::span<const std::int64_t> blocks) const;
    /// [s per step]
    double sending(const HaloForecast& halo, int ranks) const;
};

/// Sums over ranks and intervals of a run, from which a model follows.
class ModelFit {
  public:
    /// One rank in one interval: what it held, and its seconds per step, of computing and of all (waiting included,
    /// balancing and output not).
    struct Sample {
        double particles, blocks, computing, step;
    };

    /// All ranks in one interval of so many steps; `sending`: by the wire model [s per step]; `look`: seconds of
    /// balancing, of the rank that waited least. Not collective.
    void add(std::span<const Sample> ranks, double steps, double sending, double look);

    /// Without rounds, wire and moves. `prior`: the ratio of costs per particle and block. Not collective.
    TimeModel model(const CostModel& prior) const;

  private:
    double nn_ = 0, nb_ = 0, bb_ = 0, nt_ = 0, bt_ = 0;  // normal equations
    // Sums over steps, of the rank with most particles: these, its blocks, seconds of a step beyond the wire.
    double heaviest_particles_ = 0, heaviest_blocks_ = 0, stepping_ = 0;
    std::vector<double> looks_;
};

}  // namespace moraine
