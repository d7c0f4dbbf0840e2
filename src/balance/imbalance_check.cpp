#include "balance/imbalance_check.hpp"

#include <algorithm>
#include <utility>

#include "balance/load.hpp"
#include "balance/planner.hpp"

namespace moraine {
namespace {

/// Of each kind the option that a partitioner has, if all ranks can hold it, else its best of those that they can hold.
std::vector<Option> options_that_fit(std::span<const BlockLoad> blocks, const ImbalanceCheckInput& in, int ranks,
                                     const Partitioner& partitioner) {
    std::vector<Option> all = partitioner.options(blocks, in.round);
    const std::size_t offered = all.size();
    std::vector<Option> options = that_fit(std::move(all), blocks, ranks, in.most);
    if (options.size() == offered) return options;
    if (auto within = partitioner.options_within(blocks, in.most)) {
        for (Option& option : *within) {
            const auto same = [&](const Option& o) { return o.kind == option.kind; };
            if (std::none_of(options.begin(), options.end(), same)) options.push_back(std::move(option));
        }
        return options;  // a chain without such a cut has none by particles either
    }
    if (!options.empty()) return options;
    std::vector<BlockLoad> by_particles(blocks.begin(), blocks.end());
    for (BlockLoad& block : by_particles) block.weight = block.particles;
    return that_fit(partitioner.options(by_particles, in.round), blocks, ranks, in.most);
}

}  // namespace

ImbalanceCheckResult check_imbalance(std::span<const BlockLoad> blocks, const ImbalanceCheckInput& in, int ranks,
                                     const Partitioner& partitioner, const RepartitionTrigger& trigger) {
    ImbalanceCheckResult check;
    check.found.reason = "balanced";
    TriggerInput& terms = check.found.terms;
    const LoadSummary now = summary_of(loads_of_ranks(blocks, present_owners(blocks), ranks));
    terms.now = now;
    if (!trigger.needs_plan(now)) return check;
    terms = in.times;
    terms.now = now;
    std::vector<Option> options = options_that_fit(blocks, in, ranks, partitioner);
    if (options.empty()) {
        check.found.reason = "memory";
        return check;
    }
    Plan plan = best_plan(std::move(options), blocks, ranks, trigger.costs(terms, in.unit));
    terms.take(plan);
    const Decision decision = trigger.decide(terms);
    check.found.repartitioned = decision.repartition;
    check.found.reason = decision.reason;
    if (decision.repartition) check.owners = std::move(plan.owners);
    return check;
}

}  // namespace moraine
