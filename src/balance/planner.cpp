#include "balance/planner.hpp"

#include <algorithm>

namespace moraine {
namespace {

/// The most particles that one rank sends or receives.
std::int64_t busiest(std::span<const BlockLoad> blocks, std::span<const std::int32_t> from,
                     std::span<const std::int32_t> to, int ranks) {
    std::vector<std::int64_t> sent(static_cast<std::size_t>(ranks), 0), received = sent;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        if (from[b] < 0 || from[b] >= ranks || from[b] == to[b]) continue;
        sent[from[b]] += blocks[b].particles;
        received[to[b]] += blocks[b].particles;
    }
    std::int64_t most = 0;
    for (int r = 0; r < ranks; ++r) most = std::max({most, sent[r], received[r]});
    return most;
}

}  // namespace

const char* name_of(PlanKind kind) {
    constexpr const char* names[plan_kinds] = {"keep", "natural", "relabelled", "least migration"};
    return names[static_cast<std::size_t>(kind)];
}

double migration_seconds(std::span<const BlockLoad> blocks, std::span<const std::int32_t> from,
                         std::span<const std::int32_t> to, int ranks, const MoveModel& move) {
    const std::int64_t most = busiest(blocks, from, to, ranks);
    return most > 0 ? move.start + move.particle * static_cast<double>(most) : 0;
}

Plan best_plan(std::vector<Option> options, std::span<const BlockLoad> blocks, int ranks, const PlanCosts& costs) {
    const std::vector<std::int32_t> present = present_owners(blocks);
    const bool is_held = std::all_of(present.begin(), present.end(), [&](int r) { return r >= 0 && r < ranks; });
    if (costs.may_keep && is_held) options.push_back({PlanKind::keep, present});
    std::stable_sort(options.begin(), options.end(), [](const Option& x, const Option& y) { return x.kind < y.kind; });

    Plan best;
    double least = std::numeric_limits<double>::infinity();
    auto all_seconds = Plan::not_offered();
    for (Option& option : options) {
        const LoadSummary load = summary_of(loads_of_ranks(blocks, option.owners, ranks));
        const double migration = migration_seconds(blocks, present, option.owners, ranks, costs.move);
        const double seconds = costs.steps * costs.step * static_cast<double>(load.max) + migration;
        all_seconds[static_cast<std::size_t>(option.kind)] = seconds;
        if (seconds >= least) continue;
        least = seconds;
        best = {option.kind, std::move(option.owners), load, migration, {}};
    }
    best.seconds = all_seconds;
    return best;
}

std::int64_t fullest(std::span<const BlockLoad> blocks, std::span<const std::int32_t> owners, int ranks) {
    std::vector<std::int64_t> held(static_cast<std::size_t>(ranks), 0);
    for (std::size_t b = 0; b < blocks.size(); ++b) held[static_cast<std::size_t>(owners[b])] += blocks[b].particles;
    return *std::max_element(held.begin(), held.end());
}

std::vector<Option> that_fit(std::vector<Option> options, std::span<const BlockLoad> blocks, int ranks,
                             std::int64_t most) {
    std::erase_if(options, [&](const Option& o) { return fullest(blocks, o.owners, ranks) > most; });
    return options;
}

}  // namespace moraine
