#pragma once
// Imbalance: the maximum over the mean of all ranks, idle ones included.
//
//   max/mean = max * ranks / total,   1 where there is no load at all
//
// A step lasts as long as its slowest rank, so 1 - mean/max of the ranks' time is lost. Leaving idle
// ranks out of the mean would make a partition that uses half of the machine look perfect.

#include <algorithm>
#include <cstdint>
#include <span>

namespace moraine {

/// Kept as integers, so that partitions can be compared exactly.
struct LoadSummary {
    std::int64_t max = 0;
    std::int64_t total = 0;
    int ranks = 1;

    double imbalance() const {
        return total == 0 ? 1.0 : static_cast<double>(max) * ranks / static_cast<double>(total);
    }
};

/// One load per rank. Not collective.
inline LoadSummary summary_of(std::span<const std::int64_t> loads) {
    LoadSummary s{0, 0, static_cast<int>(loads.size())};
    for (std::int64_t load : loads) s.max = std::max(s.max, load), s.total += load;
    return s;
}

}  // namespace moraine
