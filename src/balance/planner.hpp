#pragma once
// Which of the owners that a partitioner offers is the cheapest until the next repartition.
//
//   seconds(option) = steps * step * heaviest load + (anything moves: start + particle * busiest)
//
// busiest: the most particles that one rank sends or receives; moves of different ranks overlap. Keeping the
// present owners moves nothing and is an option where the trigger leaves the choice. Of equals the first in
// the order of PlanKind. A pure function of numbers that are the same on all ranks.

#include <array>
#include <limits>

#include "balance/load.hpp"
#include "balance/partitioner.hpp"

namespace moraine {

/// Of moving blocks between ranks on a host: measured, see benchmarks/balance/results.md.
struct MoveModel {
    double start;     ///< of any repartition [s]
    double particle;  ///< sent or received by the busiest rank [s]
};
inline constexpr MoveModel host_moves{2e-3, 4e-6};
/// Between devices by direct writes, benchmarks/scaling/results.md.
inline constexpr MoveModel device_moves{1e-2, 2e-9};

/// Of blocks that go from ranks to others (those out of range have nothing to send); 0 where no particle moves [s].
/// Not collective.
double migration_seconds(std::span<const BlockLoad> blocks, std::span<const std::int32_t> from,
                         std::span<const std::int32_t> to, int ranks, const MoveModel& move);

struct PlanCosts {
    double step = 0;   ///< of a step, per unit of weight [s]
    double steps = 0;  ///< until the next repartition
    MoveModel move{0, 0};
    bool may_keep = false;
};

struct Plan {
    PlanKind kind = PlanKind::keep;
    std::vector<std::int32_t> owners;
    LoadSummary load;      ///< by weight
    double migration = 0;  ///< predicted [s]
    /// Predicted, of each PlanKind [s]; not a number where it was not on offer.
    std::array<double, plan_kinds> seconds = not_offered();

    static constexpr std::array<double, plan_kinds> not_offered() {
        std::array<double, plan_kinds> none{};
        none.fill(std::numeric_limits<double>::quiet_NaN());
        return none;
    }
};

/// "keep", "natural", "relabelled", "least migration". Not collective.
const char* name_of(PlanKind kind);

/// Of `options` and, if the costs allow it, the present owners. Not collective.
Plan best_plan(std::vector<Option> options, std::span<const BlockLoad> blocks, int ranks, const PlanCosts& costs);

// Memory as a second constraint: no rank is given more particles than it can hold.

/// Particles of the fullest rank. Not collective.
std::int64_t fullest(std::span<const BlockLoad> blocks, std::span<const std::int32_t> owners, int ranks);

/// Those of `options` under which no rank holds more than `most` particles. Not collective.
std::vector<Option> that_fit(std::vector<Option> options, std::span<const BlockLoad> blocks, int ranks,
                             std::int64_t most);

}  // namespace moraine
