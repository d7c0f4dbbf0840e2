#pragma once
// A run that never happened: recorded loads, another number of ranks, another partitioner or trigger.
//
// At each imbalance check owners come over from the imbalance check before (interval.hpp), the trigger decides by the
// same code as in a run (trigger.hpp, planner.hpp) and with time by the model, and what the interval to come costs is
// added up: its imbalance is the mean of those at its two ends, the halo is that at its begin.

#include <memory>
#include <string>

#include "balance/trigger.hpp"
#include "balance/weight.hpp"
#include "replay/halo_forecast.hpp"
#include "replay/time_model.hpp"

namespace moraine {

/// Sums over a replayed run, and what follows from them.
struct ForecastResult {
    int ranks = 1;
    std::string partitioner, trigger;
    std::int64_t steps = 0, checks = 0, intervals = 0;
    double imbalance_sum = 0, imbalance_max = 1;  ///< of particles; sum over steps
    double imbalance_time_sum = 0;                ///< of modelled computing; sum over steps
    double tiles_between = 0;                     ///< of tiles, to other hosts
    double tiles = 0, bytes = 0, face_cut = 0;    ///< sums over intervals; bytes: over steps and exchanges
    double neighbours_mean = 0;                   ///< sum over intervals
    std::int32_t neighbours_max = 0;
    std::int64_t repartitions = 0, migrated_particles = 0, migrated_blocks = 0;
    double plan_seconds = 0, plan_seconds_max = 0;  ///< measured here: of a plan, on one core
    std::int64_t plans = 0;
    /// [s]; computing: of the slowest rank by its load; timing noise: beyond that; ideal: perfectly balanced; checking:
    /// with plans, as measured here.
    double computing = 0, timing_noise = 0, ideal = 0, sending = 0, migration = 0, checking = 0;

    double imbalance_mean() const { return steps > 0 ? imbalance_sum / static_cast<double>(steps) : 1; }
    double seconds() const { return computing + timing_noise + sending + migration + checking; }
    double efficiency() const { return seconds() > 0 ? ideal / seconds() : 1; }
};

class Forecast {
  public:
    /// `relabelled_only`: one option, as the offline optimum has it. Throws InputError for a partitioner that is not
    /// there. `model` and `layout` must outlive it.
    Forecast(const BalanceSpec& spec, const Layout& layout, const CostModel& weights, int ranks, const TimeModel& model,
             bool relabelled_only = false);

    /// Owners at the next imbalance check; `carry` tells of blocks since the imbalance check before. Not collective.
    void check(Interval& now, const Carry& carry);

    /// The halo until the next imbalance check, of the owners that check() found. Not collective.
    void add_halo(const HaloSurroundings& around, int node_bytes);

    const Partitioner& partitioner() const { return *partitioner_; }
    const std::vector<std::int32_t>& owners() const { return owners_; }
    const ForecastResult& result() const { return result_; }

  private:
    struct Loads {
        std::vector<std::int64_t> particles, blocks;  ///< of each rank; particles by what they cost
        LoadSummary weight;
    };
    Loads loads_of(const Interval& now) const;
    void add_end_of_interval(const Loads& loads, std::int64_t steps, double exchanges);
    void decide(const Interval& now, const Loads& loads);
    void take_mark(const Loads& loads);

    const Layout& layout_;
    const TimeModel& model_;
    int ranks_;
    bool relabelled_only_;
    HostOfRank hosts_;  ///< none: they are not told apart
    std::unique_ptr<Partitioner> partitioner_;
    RepartitionTrigger trigger_;
    BlockWeight weight_;
    std::vector<std::int32_t> owners_;
    ForecastResult result_;
    // As of the begin of the interval under way: imbalance of particles and time; seconds per step.
    double imbalance_ = 1, imbalance_time_ = 1, slowest_ = 0, waiting_ = 0, mean_ = 0;
    HaloForecast halo_;
    std::int64_t step_ = -1, last_repartition_ = 0, round_ = 0;
    double lost_ = 0;  // to imbalance since the last repartition [s]
};

/// "never", "every", "threshold", "planned". Not collective.
const char* name_of(Trigger trigger);

}  // namespace moraine
