#pragma once
// The cut of a chain that moves the fewest particles, among all whose heaviest part is at most (1 + tolerance)
// times the optimal one, when every part may go to any rank.
//
//   F(k, i)   most particles that stay, if the first i links are cut into k parts; apart from it the same
//             where the home that link i lies in has not been given to a part yet
//
// A part keeps what its rank holds in it, and each rank takes one part. Homes (owner_affinity.hpp) are pieces of the
// chain in a row, so parts and homes that overlap never cross, and it is enough to know of one home whether it is
// taken. Begins of parts are taken by sliding maxima: O(1) for each state (k, i); for k parts i lies between
// what must and what can be covered. A cut may have fewer parts than ranks. Exact if each rank holds one
// piece of the chain (a test tries every cut and every assignment); else for the homes alone.
//
// The tolerance is of the optimal bottleneck, not of the mean: the mean cannot be had where blocks are
// heavy, and a limit below the optimum leaves no cut at all. The time of a step is then at most
// 1 + tolerance times the best.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "balance/cut.hpp"
#include "balance/owner_affinity.hpp"

namespace moraine {

/// What a step may last longer than with the best cut, for the sake of moving less; under the 5 % of the standard
/// threshold, so that a cut of this kind does not call for the next one.
inline constexpr double migration_tolerance = 0.02;

struct RankedCut {
    std::vector<std::int64_t> cuts;     ///< parts + 1 first links, as of exact_cut(); empty parts last
    std::vector<std::int32_t> rank_of;  ///< of each part; -1: none that it would keep something of
};

/// Among the cuts whose parts keep to the limit of memory, which some cut into so many parts must; the optimum is
/// theirs. Nothing where there is nothing to keep, no weight, or too much to search (more than 2^23 states: few links
/// so heavy that all others fit anywhere). Not collective.
std::optional<RankedCut> least_migration(std::span<const std::int64_t> weights, const OwnerAffinity& homes, int parts,
                                         double tolerance, const MemoryLimit& memory = {});

}  // namespace moraine
