#pragma once
// What the blocks weigh, and what the steps since the last repartition took: all that balancing knows of a run.
//
// Loads are counts of particles and cells, weighed (balance/weight.hpp); times come with the agreement of each step.
// Whether all is well is told from the agreements alone, before anything is gathered; only the weight by `cost` must
// look at every block.

#include <vector>

#include "balance/calibration.hpp"
#include "balance/imbalance_check.hpp"
#include "balance/measured_cost.hpp"
#include "balance/weight.hpp"
#include "engine/agreement.hpp"
#include "engine/engine.hpp"

namespace moraine {

class MeasuredLoads {
  public:
    /// costs: of the engine's machine; cells: of a block. comm must outlive it. Not collective.
    MeasuredLoads(const BalanceSpec& spec, const Comm& comm, const CostModel& costs, int cells)
        : comm_(comm), weight_(spec, costs, cells), calibration_(costs) {}

    /// Whether weights need the occupied cells of each block.
    bool weighs_cells() const { return weight_.is_cost(); }
    std::int64_t weight(std::int64_t particles, std::int64_t cells) const { return weight_(particles, cells); }
    /// Time of a unit of weight in a step, by the model [s].
    double unit() const { return weight_.seconds(); }

    /// Of this rank's blocks. Not collective.
    std::vector<BlockLoad> of(const BlockCounts& mine) const;
    /// Of the occupied blocks of all ranks, in key order. Collective.
    std::vector<BlockLoad> gather(const BlockCounts& mine) const;

    /// What the ranks agreed on in a step, and this rank's part in it. Not collective.
    void add(const Agreement& agreed, const Agreement& own);
    /// Refines the weights by the time spent computing since this was called before; computing: since the run began
    /// [s]. Collective.
    void refine(const BlockCounts& mine, std::int64_t step, double computing);
    /// The run goes on from a checkpoint of this step. Not collective.
    void resume(std::int64_t step) { last_repartition_ = step; }
    /// Blocks have moved at this step. Not collective.
    void begin_again(std::int64_t step);

    /// By the last agreement: no plan is worth making, and `found` says why. Not collective.
    bool is_balanced(const RepartitionTrigger& trigger, std::int64_t step, ImbalanceCheck& found) const;
    /// What steps took by the last agreement. Not collective.
    void take_times(std::int64_t step, TriggerInput& terms) const;

  private:
    const Comm& comm_;
    BlockWeight weight_;
    Calibration calibration_;
    MeasuredCost measured_cost_;
    Agreement agreed_;            ///< the last one
    double checked_seconds_ = 0;  ///< computing time up to refine() [s], and the steps of that moment
    std::int64_t checked_step_ = 0;
    double time_lost_ = 0;  ///< to imbalance since the last repartition [s]
    std::int64_t last_repartition_ = 0;
};

}  // namespace moraine
