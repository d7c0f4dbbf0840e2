#pragma once
// When to repartition. A pure function of plain numbers that are the same on all ranks.
//
//   never
//   every       at each multiple of balance.interval, whatever the balance
//   threshold   max/mean above balance.threshold, and the plan removes at least a tenth of what is above
//               the mean: few blocks per rank must not move for ever after a balance they cannot have
//   planned     tau u - U >= C, the plan is better at all, and cheaper than to keep what is
//
// u: time that a step loses now to imbalance (slowest rank - mean), U: time lost since the last
// repartition, tau: steps since then, C: predicted time of the migration. tau u - U is what the growth of
// the loss has cost: a constant loss, which no partition would remove, cancels.
//
// What the planner (planner.hpp) reckons with: the next repartition is as far as the last one, and at least an
// interval. By rule `planned` time is measured; by the others it follows the model, so that a run repeats itself.

#include <cstdint>
#include <string>

#include "balance/load.hpp"
#include "balance/partitioner.hpp"
#include "balance/planner.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

struct TriggerInput {
    std::int64_t step = 0;                                         ///< steps done
    std::int64_t last_repartition = 0;                             ///< the same, at the last repartition or the start
    LoadSummary now;                                               ///< by weight, under the present owners
    LoadSummary plan;                                              ///< by weight, under the planned owners
    double slowest = 0;                                            ///< computing time of the slowest rank [s per step]
    double loses = 0;                                              ///< u [s per step]
    double lost = 0;                                               ///< U [s]
    double migration = 0;                                          ///< C [s]
    PlanKind kind = PlanKind::natural;                             ///< of the plan
    std::array<double, plan_kinds> seconds = Plan::not_offered();  ///< predicted, of each kind [s]

    void take(const Plan& p) { plan = p.load, migration = p.migration, kind = p.kind, seconds = p.seconds; }
};

struct Decision {
    bool repartition = false;
    const char* reason = "";  ///< one or two words for the records
};

class RepartitionTrigger {
  public:
    /// Throws InputError for an interval below 1 or a threshold below 1. Not collective.
    RepartitionTrigger(const BalanceSpec& spec, const Partitioner& partitioner, const MoveModel& moves = host_moves);

    /// Is an imbalance check due at this step? Never so under a static partitioner. Not collective.
    bool is_due(std::int64_t step) const;

    /// Is it worth making a plan, given the loads of now? Not collective.
    bool needs_plan(const LoadSummary& now) const;

    /// Can a plan be worth it? By rule `planned` not before the growth of the loss has cost what the smallest migration
    /// takes. Plans and loads need not be known. Not collective.
    bool may_pay(const TriggerInput& input) const;

    /// What the planner reckons with. `unit`: time of a unit of weight in a step, by the model [s]. Not collective.
    PlanCosts costs(const TriggerInput& input, double unit) const;

    /// A migration that was predicted to take so long took so long [s], the same on all ranks. Not collective.
    void learn(double predicted, double took);

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
    MoveModel moves_;
    double moves_slower_ = 1;  // than the model
};

}  // namespace moraine
