#pragma once
// The best times to repartition, known only afterwards: what a trigger is measured against.
//
//   F(j) = min over i < j of  F(i) + S(i, j) + C(i, j)        F(first) = 0
//
// S(i, j): time of the steps from look i to look j with the partition made at i, C(i, j): predicted time of the
// migration from it to that made at j. Exact for partitions that depend on the loads of their look alone (not phg)
// and are relabelled: then what came before i changes nothing but names (and ties of the greedy relabelling,
// a thousandth in the tests), of hosts too if all have as many ranks. All imbalance checks are in memory, and work
// grows with their square.

#include <vector>

#include "replay/forecast.hpp"

namespace moraine {

struct Optimum {
    double seconds = 0;             ///< of computing and migration
    std::int64_t repartitions = 0;  ///< after the first
};

/// carries[k]: from look k - 1 to look k. Throws InputError as Forecast does. Not collective.
Optimum offline_optimum(const BalanceSpec& spec, const Layout& layout, const CostModel& weights, int ranks,
                        const TimeModel& model, const std::vector<Interval>& intervals,
                        const std::vector<Carry>& carries);

}  // namespace moraine
