#pragma once
// What a run recorded, checked and in terms of the balance: its looks one after another, how its time went, and how
// many ranks its loads can feed. Reads files only; knows no MPI.

#include <array>
#include <functional>
#include <string>

#include "io/block_loads.hpp"
#include "replay/forecast.hpp"
#include "replay/replay_options.hpp"

namespace moraine {

class ReplayRecord {
  public:
    /// Reads the whole record once: it is checked, and the time model calibrated. Throws InputError if there is no
    /// record, or one that is truncated, damaged or too short.
    explicit ReplayRecord(const ReplayOptions& options);

    const Layout& layout() const { return layout_; }         ///< refined, if that was asked for
    const BalanceSpec& balance() const { return balance_; }  ///< of the run
    const CostModel& weights() const { return weights_; }
    const TimeModel& model() const { return model_; }
    int node_bytes() const { return header_.node_bytes; }
    std::int64_t last_step() const { return last_step_; }
    int checks() const { return checks_; }
    std::int64_t blocks_min() const { return blocks_min_; }
    std::int64_t blocks_max() const { return blocks_max_; }

    /// The most ranks whose heaviest has at most `feed_limit` times the mean, of the best cut along the Morton curve:
    /// at the start and at the worst of the imbalance checks that are replayed.
    std::int64_t feeds_at_start() const { return feeds_at_start_; }
    std::int64_t feeds_always() const { return feeds_always_; }
    static constexpr double feed_limit = 1.25;

    /// Blocks of the grid that is replayed, refined if that was asked for, that the fastest of the run went through
    /// from one imbalance check to the next, in the mean of the rows of history.csv; 0 where that is not known. Beyond
    /// one, owners of the blocks before say little of those of now.
    double blocks_between_checks() const { return blocks_between_checks_; }

    /// What the run itself did; measured, of the grid as it was run.
    /// Share of the particle-steps that slept or, with --sleep, would have; 0 where all count as awake.
    double asleep_share() const { return particle_steps_ > 0 ? asleep_steps_ / particle_steps_ : 0; }
    /// Whether that is of the run itself.
    bool slept() const { return sleepers_ == SleepersRecord::asleep; }

    const ForecastResult& measured() const { return measured_; }
    double measured_seconds() const { return measured_seconds_; }

    /// Check after check; `carry` from the one before. No two imbalance checks are in memory but these.
    void each_check(const std::function<void(Interval& now, const Carry& carry)>& f) const;

  private:
    bool next(BlockLoadReader& reader, LoadFrame& frame) const;
    /// Takes the rows out of the frame.
    Interval interval_of(LoadFrame& frame) const;
    void check_sleepers() const;
    void count_sleepers(const LoadFrame& frame);
    Interval refined(Interval interval) const;
    void read_through();
    void check_end() const;
    void set_network(TimeModel& model) const;
    void calibrate(const std::string& directory);
    void measure(const LoadFrame& frame, const Interval& before, const Interval& now, const Partitioner& partitioner);
    double moves_at_end(const Interval& now, const std::vector<std::int32_t>& held, int ranks) const;
    std::int64_t children_of_a_block() const { return std::int64_t(1) << (layout_.dimensions * options_.refine); }
    void count(const Interval& coarse);
    void feed(const Interval& coarse);
    bool weighs_sleepers() const { return slept() || options_.sleep; }

    const ReplayOptions& options_;
    std::string path_;
    LoadHeader header_;
    SleepersRecord sleepers_ = SleepersRecord::none;
    Layout coarse_, layout_;
    BalanceSpec balance_;
    CostModel weights_{};
    TimeModel model_;
    ModelFit fit_;
    ForecastResult measured_;
    double measured_seconds_ = 0, asleep_steps_ = 0, particle_steps_ = 0;
    std::array<double, 2> sleepers_before_{};  ///< particles of the last frame, and those of them that sleep
    std::int64_t last_step_ = -1, blocks_min_ = 0, blocks_max_ = 0, feeds_at_start_ = 0, feeds_always_ = 0;
    int checks_ = 0;
    double blocks_between_checks_ = 0;
};

}  // namespace moraine
