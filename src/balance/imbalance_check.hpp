#pragma once
// An imbalance check: from the loads of now to a decision and the owners to be.
//
// A pure function of numbers that are the same on all ranks, so that every rank decides alike, and may do so on a
// thread of its own.

#include <span>
#include <string>
#include <vector>

#include "balance/partitioner.hpp"
#include "balance/trigger.hpp"

namespace moraine {

/// What an imbalance check found, for the records.
struct ImbalanceCheck {
    bool repartitioned = false;
    std::string reason;
    TriggerInput terms;
};

/// What an imbalance check must know besides the loads.
struct ImbalanceCheckInput {
    TriggerInput times;      ///< steps, and what they took
    std::int64_t round = 0;  ///< partitions made
    std::int64_t most = 0;   ///< particles that any rank can hold
    double unit = 0;         ///< time of a unit of weight in a step, by the model [s]
};

struct ImbalanceCheckResult {
    ImbalanceCheck found;
    std::vector<std::int32_t> owners;  ///< of each block; none where all stays
};

/// blocks: of all ranks, in key order. Where a rank cannot hold its part by weight, a chain is cut as evenly by weight
/// as its ranks can hold, and where it has no such cut all stays. Partitioners that look for none make parts by
/// particles; where a rank cannot hold those either, all stays. Collective where the partitioner is.
ImbalanceCheckResult check_imbalance(std::span<const BlockLoad> blocks, const ImbalanceCheckInput& input, int ranks,
                                     const Partitioner& partitioner, const RepartitionTrigger& trigger);

}  // namespace moraine
