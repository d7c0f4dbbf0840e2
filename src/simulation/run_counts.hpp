#pragma once
// What a run counts about itself, for its records.

#include <algorithm>
#include <cstdint>

#include "engine/agreement.hpp"

namespace moraine {

/// Counts over the whole run. Those of a rank are summed when they are reported.
struct RunCounts {
    std::int64_t repartitions = 0;        ///< same on all ranks
    std::int64_t epochs = 0;              ///< that were renewed in place; same on all ranks
    std::int64_t migrated_particles = 0;  ///< sent by this rank in repartitions
    std::int64_t migrated_blocks = 0;
    std::int64_t crossed_particles = 0;         ///< walked from this rank to others
    std::int64_t halo_bytes = 0;                ///< sent by this rank
    std::int64_t blocks_between_hosts = 0;      ///< whose sums this rank sends to other hosts, in an exchange of now
    std::int64_t blocks_between_hosts_sum = 0;  ///< over steps
    std::int64_t clamped_boxes = 0;             ///< contiguous GIMP boxes held at half a cell, particle-steps
    double imbalance_sum = 0;                   ///< over steps, of particles by what they cost; same on all ranks
    double imbalance_max = 0;
    double imbalance_time_sum = 0;  ///< of measured compute time
    double seconds_lost = 0;        ///< to imbalance: slowest rank less mean [s]; same on all ranks
    std::int64_t exchanges = 0;     ///< of the halo: one in each round and substep; same on all ranks
    std::int64_t steps = 0;         ///< of this process: what the means are over
    double particle_steps = 0;
    double slept_steps = 0;  ///< of these, of particles that slept

    /// What the ranks agreed on in a step. Not collective.
    void add(const Agreement& agreed, int ranks) {
        const double mean = static_cast<double>(agreed.load_sum) / ranks;
        const double imbalance = mean > 0 ? static_cast<double>(agreed.load) / mean : 1;
        imbalance_sum += imbalance;
        imbalance_max = std::max(imbalance_max, imbalance);
        const double mean_seconds = agreed.seconds_sum / ranks;
        imbalance_time_sum += mean_seconds > 0 ? agreed.seconds / mean_seconds : 1;
        seconds_lost += agreed.seconds - mean_seconds;
        blocks_between_hosts_sum += blocks_between_hosts;
        ++steps;
        particle_steps += static_cast<double>(agreed.count_sum);
        slept_steps += static_cast<double>(agreed.asleep_sum);
    }
};

}  // namespace moraine
