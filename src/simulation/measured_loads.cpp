#include "simulation/measured_loads.hpp"

#include "blocks/key_order.hpp"
#include "simulation/rebalance.hpp"

namespace moraine {

namespace {

/// Particles of a block by what they cost.
std::int64_t load_of(const BlockCounts& counts, std::size_t b) {
    const std::int64_t particles = counts.count[b];
    return moraine::load_of(particles, !counts.asleep.empty() && counts.asleep[b] != 0 ? particles : 0);
}

}  // namespace

std::vector<BlockLoad> MeasuredLoads::of(const BlockCounts& mine) const {
    std::vector<BlockLoad> rows;
    rows.reserve(mine.key.size());
    for (std::size_t b = 0; b < mine.key.size(); ++b) {
        const std::int64_t cells = mine.cells.empty() ? 0 : mine.cells[b];
        rows.push_back({mine.key[b], mine.count[b], weight_(load_of(mine, b), cells), comm_.rank()});
    }
    return rows;
}

std::vector<BlockLoad> MeasuredLoads::gather(const BlockCounts& mine) const {
    std::vector<std::int64_t> counts;
    const std::vector<BlockLoad> all = comm_.all_gather(of(mine), &counts);
    return merged(in_key_order(all, counts));
}

void MeasuredLoads::add(const Agreement& agreed, const Agreement& own) {
    agreed_ = agreed;
    time_lost_ += agreed.seconds - agreed.seconds_sum / comm_.size();
    if (weight_.is_time())
        measured_cost_.add({own.seconds, agreed.seconds, agreed.seconds_sum, weight_.with_blocks(own.load, own.blocks),
                            weight_.with_blocks(agreed.load_sum, agreed.blocks)});
}

void MeasuredLoads::refine(const BlockCounts& mine, std::int64_t step, double computing) {
    if (weight_.is_time()) weight_.set_model({measured_cost_.picoseconds(weight_.model().a), 0, 0});
    if (!weighs_cells()) return;
    const auto steps = static_cast<double>(step - checked_step_);
    CostSample sample;
    for (std::size_t b = 0; b < mine.key.size(); ++b) {
        sample.particles += static_cast<double>(load_of(mine, b));
        sample.cells += static_cast<double>(mine.cells[b]);
    }
    sample.blocks = static_cast<double>(mine.key.size());
    if (steps > 0) sample.seconds = (computing - checked_seconds_) / steps;
    checked_seconds_ = computing;
    checked_step_ = step;
    calibration_.add(comm_.all_gather(std::vector<CostSample>{sample}));
    weight_.set_model(calibration_.model());
}

void MeasuredLoads::begin_again(std::int64_t step) {
    last_repartition_ = step;
    time_lost_ = 0;
    measured_cost_.forget();
}

bool MeasuredLoads::is_balanced(const RepartitionTrigger& trigger, std::int64_t step, ImbalanceCheck& found) const {
    if (weighs_cells()) return false;
    found.terms.now = weight_.is_time() ? measured_cost_.load(comm_.size())
                                        : LoadSummary{agreed_.load, agreed_.load_sum, comm_.size()};
    found.reason = "balanced";
    if (!trigger.needs_plan(found.terms.now)) return true;
    take_times(step, found.terms);
    found.reason = "not worth it";
    return !trigger.may_pay(found.terms);
}

void MeasuredLoads::take_times(std::int64_t step, TriggerInput& terms) const {
    terms.step = step;
    terms.last_repartition = last_repartition_;
    terms.slowest = agreed_.seconds;
    terms.loses = agreed_.seconds - agreed_.seconds_sum / comm_.size();
    terms.lost = time_lost_;
}

}  // namespace moraine
