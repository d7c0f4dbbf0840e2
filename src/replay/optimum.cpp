#include "replay/optimum.hpp"

#include <limits>

#include "balance/host_relabel.hpp"
#include "balance/relabel.hpp"

namespace moraine {
namespace {

/// What follows from a partition made at one imbalance check, for every later imbalance check.
class Followed {
  public:
    Followed(const Layout& layout, const TimeModel& model, const Partitioner& partitioner, int ranks)
        : layout_(layout), model_(model), partitioner_(partitioner), ranks_(ranks), hosts_(model.hosts(ranks)) {}

    void begin(const Interval& interval, std::vector<std::int32_t> owners) {
        owners_ = std::move(owners);
        step_ = interval.step;
        seconds_ = 0;
        slowest_ = slowest(interval);
    }

    void go_on(const Interval& interval, const Carry& carry) {
        owners_ = carry.owners(owners_, interval, layout_, partitioner_);
        const double before = slowest_;
        slowest_ = slowest(interval);
        seconds_ += static_cast<double>(interval.step - step_) * (before + slowest_) / 2;
        step_ = interval.step;
    }

    double seconds() const { return seconds_; }

    double migration_to(const Interval& interval, const std::vector<std::int32_t>& parts) const {
        std::vector<BlockLoad> blocks = interval.blocks;
        for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].owner = owners_[b];
        const std::vector<std::int32_t> rank_of =
            host_count(hosts_) > 1 ? relabel_on_hosts(blocks, parts, hosts_) : relabel(blocks, parts, ranks_);
        std::vector<std::int32_t> to(parts.size());
        for (std::size_t b = 0; b < to.size(); ++b) to[b] = rank_of[parts[b]];
        return model_.moves_slower * migration_seconds(blocks, owners_, to, ranks_, model_.moves);
    }

  private:
    double slowest(const Interval& interval) const {
        std::vector<std::int64_t> blocks(static_cast<std::size_t>(ranks_), 0);
        for (std::int32_t owner : owners_) ++blocks[owner];
        return model_.slowest(interval.loads(owners_, ranks_), blocks);
    }

    const Layout& layout_;
    const TimeModel& model_;
    const Partitioner& partitioner_;
    int ranks_;
    HostOfRank hosts_;
    std::vector<std::int32_t> owners_;
    std::int64_t step_ = 0;
    double seconds_ = 0, slowest_ = 0;
};

}  // namespace

Optimum offline_optimum(const BalanceSpec& spec, const Layout& layout, const CostModel& weights, int ranks,
                        const TimeModel& model, const std::vector<Interval>& intervals,
                        const std::vector<Carry>& carries) {
    const std::unique_ptr<Partitioner> partitioner = make_partitioner(spec, layout, ranks, model.hosts(ranks));
    const BlockWeight weight(spec, weights);
    std::vector<std::vector<std::int32_t>> parts;
    for (const Interval& interval : intervals) {
        std::vector<BlockLoad> blocks = interval.blocks;
        for (std::size_t b = 0; b < blocks.size(); ++b)
            blocks[b].weight = weight(interval.load(b), 0), blocks[b].owner = -1;
        parts.push_back(partitioner->owners(blocks, static_cast<std::int64_t>(parts.size())));
    }
    const std::size_t last = intervals.size() - 1;
    std::vector<double> best(intervals.size(), std::numeric_limits<double>::infinity());
    std::vector<std::int64_t> repartitions(intervals.size(), 0);
    best[0] = 0;
    Followed followed(layout, model, *partitioner, ranks);
    for (std::size_t i = 0; i < last; ++i) {
        followed.begin(intervals[i], parts[i]);
        for (std::size_t j = i + 1; j <= last; ++j) {
            followed.go_on(intervals[j], carries[j]);
            const double migration = j == last ? 0 : followed.migration_to(intervals[j], parts[j]);
            const double seconds = best[i] + followed.seconds() + migration;
            if (seconds >= best[j]) continue;
            best[j] = seconds;
            repartitions[j] = repartitions[i] + (j == last ? 0 : 1);
        }
    }
    return {best[last], repartitions[last]};
}

}  // namespace moraine
