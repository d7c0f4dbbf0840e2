#include "replay/forecast.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "balance/relabel.hpp"

namespace moraine {

const char* name_of(Trigger trigger) {
    constexpr const char* names[] = {"never", "every", "threshold", "planned"};
    return names[static_cast<std::size_t>(trigger)];
}

Forecast::Forecast(const BalanceSpec& spec, const Layout& layout, const CostModel& weights, int ranks,
                   const TimeModel& model, bool relabelled_only)
    : layout_(layout),
      model_(model),
      ranks_(ranks),
      relabelled_only_(relabelled_only),
      hosts_(model.hosts(ranks)),
      partitioner_(make_partitioner(spec, layout, ranks, hosts_)),
      trigger_(spec, *partitioner_, model.moves),
      weight_(spec, weights) {
    result_.ranks = ranks;
    result_.partitioner = spec.partitioner;
    result_.trigger = partitioner_->is_static() ? "static" : name_of(spec.trigger);
}

Forecast::Loads Forecast::loads_of(const Interval& now) const {
    Loads loads;
    loads.particles = now.loads(owners_, ranks_);
    loads.blocks.assign(static_cast<std::size_t>(ranks_), 0);
    for (std::int32_t owner : owners_) ++loads.blocks[owner];
    loads.weight = summary_of(loads_of_ranks(now.blocks, owners_, ranks_));
    return loads;
}

void Forecast::take_mark(const Loads& loads) {
    const auto total = [](const std::vector<std::int64_t>& v) {
        return static_cast<double>(std::accumulate(v.begin(), v.end(), std::int64_t{0}));
    };
    imbalance_ = summary_of(loads.particles).imbalance();
    slowest_ = model_.slowest(loads.particles, loads.blocks);
    waiting_ = model_.waiting(loads.particles, loads.blocks);
    const double n = total(loads.particles);
    mean_ = model_.busy(n, total(loads.blocks)) / ranks_;
    imbalance_time_ = mean_ > 0 ? (slowest_ + waiting_) / mean_ : 1;
}

/// `loads` are those that the owners of the interval have come to.
void Forecast::add_end_of_interval(const Loads& loads, std::int64_t steps, double exchanges) {
    const double imbalance = imbalance_, imbalance_time = imbalance_time_, slowest = slowest_, waiting = waiting_,
                 mean = mean_;
    const auto n = static_cast<double>(steps);
    take_mark(loads);
    result_.steps += steps;
    ++result_.intervals;
    result_.imbalance_sum += n * (imbalance + imbalance_) / 2;
    result_.imbalance_time_sum += n * (imbalance_time + imbalance_time_) / 2;
    result_.imbalance_max = std::max({result_.imbalance_max, imbalance, imbalance_});
    result_.computing += n * (slowest + slowest_) / 2;
    result_.timing_noise += n * (waiting + waiting_) / 2;
    result_.ideal += n * (mean + mean_) / 2;
    result_.sending += n * (model_.constant + model_.sending(halo_, ranks_, exchanges));
    result_.tiles += static_cast<double>(halo_.tiles);
    result_.tiles_between += static_cast<double>(halo_.tiles_between);
    result_.bytes += n * exchanges * static_cast<double>(halo_.bytes);
    result_.face_cut += static_cast<double>(halo_.face_cut);
    result_.neighbours_mean += halo_.neighbours_mean;
    result_.neighbours_max = std::max(result_.neighbours_max, halo_.neighbours_max);
    lost_ += n * (slowest - mean + slowest_ - mean_) / 2;
}

void Forecast::decide(const Interval& now, const Loads& loads) {
    const std::vector<BlockLoad>& blocks = now.blocks;
    const std::int64_t step = now.step;
    if (!trigger_.is_due(step)) return;
    ++result_.checks;
    result_.checking += model_.check;
    if (!trigger_.needs_plan(loads.weight)) return;
    TriggerInput in;
    in.step = step;
    in.last_repartition = last_repartition_;
    in.now = loads.weight;
    in.slowest = slowest_;
    in.loses = slowest_ - mean_;
    in.lost = lost_;
    const auto start = std::chrono::steady_clock::now();
    std::vector<Option> options;
    if (relabelled_only_)
        options = {{PlanKind::relabelled, partitioner_->owners(blocks, round_)}};
    else
        options = partitioner_->options(blocks, round_);
    const Plan plan = best_plan(std::move(options), blocks, ranks_, trigger_.costs(in, weight_.seconds()));
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ++result_.plans;
    result_.plan_seconds += took;
    result_.checking += took;
    result_.plan_seconds_max = std::max(result_.plan_seconds_max, took);
    in.take(plan);
    if (!trigger_.decide(in).repartition) return;
    const Moved travels = moved(blocks, plan.owners);
    ++result_.repartitions;
    ++round_;
    result_.migrated_particles += travels.particles;
    result_.migrated_blocks += travels.blocks;
    result_.migration += model_.moves_slower * plan.migration;
    owners_ = plan.owners;
    last_repartition_ = step;
    lost_ = 0;
    take_mark(loads_of(now));
}

void Forecast::check(Interval& now, const Carry& carry) {
    std::vector<BlockLoad>& blocks = now.blocks;
    for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].weight = weight_(now.load(b), 0);
    if (step_ < 0) {
        for (BlockLoad& block : blocks) block.owner = -1;
        partitioner_->start(blocks);
        owners_ = partitioner_->owners(blocks, round_++);
        last_repartition_ = now.step;
        take_mark(loads_of(now));
    } else {
        owners_ = carry.owners(owners_, now, layout_, *partitioner_);
        for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].owner = owners_[b];
        const Loads loads = loads_of(now);
        add_end_of_interval(loads, now.step - step_, now.exchanges);
        decide(now, loads);
    }
    step_ = now.step;
}

void Forecast::add_halo(const HaloSurroundings& around, int node_bytes) {
    halo_ = around.halo(owners_, *partitioner_, ranks_, node_bytes, hosts_);
}

}  // namespace moraine
