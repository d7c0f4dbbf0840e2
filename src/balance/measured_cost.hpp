#pragma once
// What this rank's particles cost, measured: balance.weight = "time".
//
// A rank's time per particle differs with what the particles do, with how full their cells are, with the boundary of
// its share and with the processor. A block weighs its particles, and what a block takes besides, times the time per
// particle of who holds it; blocks that move are measured by their new owner, so a few repartitions find the shares
// that take equal time, whatever the cause.

#include <cstdint>

#include "balance/load.hpp"

namespace moraine {

/// Of one step.
struct StepTimes {
    double mine = 0;                ///< this rank's computing time [s]
    double slowest = 0;             ///< of all ranks [s]
    double sum = 0;                 ///< of all ranks [s]
    std::int64_t my_particles = 0;  ///< of this rank, its blocks among them (BlockWeight::with_blocks)
    std::int64_t particles = 0;     ///< of all ranks
};

class MeasuredCost {
  public:
    /// Not collective.
    void add(const StepTimes& step);

    /// After a repartition nothing is known; the next step is one of before with particles of now. Not collective.
    void forget() {
        *this = MeasuredCost{};
        skips_ = true;
    }

    /// Time per particle and step [ps], between half and twice that of all ranks: a rank with a handful of particles
    /// has no measured cost, and would never get more. `start` before anything was measured. At least 1. Not
    /// collective.
    std::int64_t picoseconds(std::int64_t start) const;

    /// Time of the slowest rank in each step, and of all ranks, added up over the last steps [ps]; the same on all
    /// ranks. Not collective.
    LoadSummary load(int ranks) const;

  private:
    // Sums over steps in which older ones fade.
    double mine_ = 0, slowest_ = 0, sum_ = 0;  // [s]
    double my_particles_ = 0, particles_ = 0;
    bool skips_ = false;
};

}  // namespace moraine
