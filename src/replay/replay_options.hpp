#pragma once
// The command line of `moraine replay`.

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

struct ReplayOptions {
    std::string directory;                  ///< of the run
    std::vector<int> ranks;                 ///< empty: 4, 16, 64, ... as far as there are blocks
    std::vector<std::string> partitioners;  ///< empty: all that need no library
    std::vector<Trigger> triggers;          ///< empty: that of the run
    std::vector<std::string> calibrate;     ///< directories of other runs whose times the model takes in
    bool sleep = false;                     ///< weigh who would have slept as asleep
    bool regret = false;                    ///< also all triggers against the offline optimum
    double latency = 2e-6;                  ///< [s]
    double bandwidth = 5e9;                 ///< [byte/s]
    int ranks_per_host = 0;                 ///< 0: hosts are not told apart
    double latency_within = -1;             ///< a host [s]; -1: as between hosts
    double bandwidth_within = -1;           ///< a host [byte/s]; -1: as between hosts
    int every = 1;                          ///< take every so many imbalance checks only
    std::int64_t last_step = std::numeric_limits<std::int64_t>::max();
    int refine = 0;      ///< halve the cells so many times
    std::string output;  ///< CSV; empty: replay.csv in the directory
};

/// `words` follow "replay". Throws InputError. Not collective.
ReplayOptions parse_replay(const std::vector<std::string>& words);

/// Not collective.
std::string replay_help();

}  // namespace moraine
