#pragma once
// When to repartition. A pure function of plain numbers that are the same on all ranks.
//
//   never
//   every       at each multiple of balance.interval, whatever the balance
//   threshold   max/mean above balance.threshold, and the plan removes at least a tenth of what is above
//               the mean: few blocks per rank must not move for ever after a balance they cannot have
//   planned     tau u - U >= C, and the plan is better at all
//
// u: time that a step loses now to imbalance (slowest rank - mean), U: time lost since the last
// repartition, tau: steps since then, C: predicted time of the migration. tau u - U is what the growth of
// the loss has cost: a constant loss, which no partition would remove, cancels.

#include <cstdint>
#include <string>

#include "balance/imbalance.hpp"
#include "balance/partitioner.hpp"
#include "core/scene.hpp"

namespace moraine {

struct TriggerInput {
    std::int64_t step = 0;              ///< steps done
    std::int64_t last_repartition = 0;  ///< the same, at the last repartition or the start
    LoadSummary now;                    ///< by weight, under the present owners
    LoadSummary plan;                   ///< by weight, under the planned owners
    double loses = 0;                   ///< u [s per step]
    double lost = 0;                    ///< U [s]
    double migration = 0;               ///< C [s]
};

struct Decision {
    bool repartition = false;
    const char* reason = "";  ///< one or two words for the records
};

class RepartitionTrigger {
  public:
    /// Throws InputError for an interval below 1 or a threshold below 1. Not collective.
    RepartitionTrigger(const BalanceSpec& spec, const Partitioner& partitioner);

    /// Is this a step to look at the balance? Never so under a static partitioner. Not collective.
    bool is_due(std::int64_t step) const;

    /// Is it worth making a plan, given the loads of now? Not collective.
    bool needs_plan(const LoadSummary& now) const;

    /// At a step that is due. Not collective.
    Decision decide(const TriggerInput& input) const;

    /// What the user should be told once, or nothing. Not collective.
    std::string notice() const;

  private:
    Trigger rule_;
    std::int64_t interval_;
    double threshold_;
    bool is_static_;
    std::string partitioner_;
};

}  // namespace moraine
