#include "balance/trigger.hpp"

#include <algorithm>
#include <sstream>

#include "core/data/error.hpp"

namespace moraine {
namespace {

constexpr double least_share_removed = 0.1;  // of the excess over the mean, for the threshold rule

/// Largest share of the excess (max - mean) that the plan removes; 0 if it removes nothing.
double share_removed(const LoadSummary& now, const LoadSummary& plan) {
    if (plan.max >= now.max) return 0;
    return (now.imbalance() - plan.imbalance()) / (now.imbalance() - 1);
}

/// Of loads above the threshold.
Decision by_threshold(const TriggerInput& in) {
    if (share_removed(in.now, in.plan) < least_share_removed) return {false, "no better plan"};
    return {true, "threshold"};
}

/// What the growth of the loss since the last repartition has cost [s].
double growth(const TriggerInput& in) {
    return static_cast<double>(in.step - in.last_repartition) * in.loses - in.lost;
}

Decision by_plan(const TriggerInput& in) {
    if (in.kind == PlanKind::keep) return {false, "cheaper to keep"};
    if (in.plan.max >= in.now.max) return {false, "no better plan"};
    if (growth(in) < in.migration) return {false, "not worth it"};
    return {true, "planned"};
}

}  // namespace

RepartitionTrigger::RepartitionTrigger(const BalanceSpec& spec, const Partitioner& partitioner, const MoveModel& moves)
    : rule_(spec.trigger),
      interval_(spec.interval),
      threshold_(spec.threshold),
      is_static_(partitioner.is_static()),
      partitioner_(partitioner.name()),
      moves_(moves) {
    if (spec.interval < 1)
        throw InputError("balance.interval = " + std::to_string(spec.interval) +
                         " (steps between two imbalance checks). Use 1 or more?");
    if (!(spec.threshold >= 1)) {
        std::ostringstream words;
        words << "balance.threshold = " << spec.threshold << " (max/mean is never below 1). Use 1.05?";
        throw InputError(words.str());
    }
}

bool RepartitionTrigger::is_due(std::int64_t step) const {
    return !is_static_ && rule_ != Trigger::never && step > 0 && step % interval_ == 0;
}

bool RepartitionTrigger::needs_plan(const LoadSummary& now) const {
    if (is_static_ || rule_ == Trigger::never) return false;
    return rule_ != Trigger::threshold || now.imbalance() > threshold_;
}

bool RepartitionTrigger::may_pay(const TriggerInput& in) const {
    return rule_ != Trigger::planned || growth(in) >= moves_.start * moves_slower_;
}

PlanCosts RepartitionTrigger::costs(const TriggerInput& in, double unit) const {
    PlanCosts costs;
    costs.steps = static_cast<double>(std::max(interval_, in.step - in.last_repartition));
    costs.step = unit;
    costs.move = moves_;
    if (rule_ != Trigger::planned) return costs;
    costs.may_keep = true;
    if (in.slowest > 0 && in.now.max > 0) costs.step = in.slowest / static_cast<double>(in.now.max);
    costs.move.start *= moves_slower_;
    costs.move.particle *= moves_slower_;
    return costs;
}

void RepartitionTrigger::learn(double predicted, double took) {
    if (predicted <= 0 || took <= 0) return;
    const double now = moves_slower_ * took / predicted;
    moves_slower_ = std::clamp((moves_slower_ + now) / 2, 0.01, 100.0);
}

Decision RepartitionTrigger::decide(const TriggerInput& input) const {
    if (is_static_) return {false, "static"};
    switch (rule_) {
        case Trigger::never:
            return {false, "never"};
        case Trigger::every:
            return {true, "every"};
        case Trigger::threshold:
            return needs_plan(input.now) ? by_threshold(input) : Decision{false, "balanced"};
        case Trigger::planned:
            return by_plan(input);
    }
    return {};
}

std::string RepartitionTrigger::notice() const {
    if (!is_static_ || rule_ == Trigger::never) return {};
    return "balance.trigger is ignored (partitioner " + partitioner_ + " is static).";
}

}  // namespace moraine
