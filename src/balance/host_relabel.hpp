#pragma once
// Which rank gets which part of a new partition where several hosts share a run: neighbours along the chain on one
// host, and few particles over the network.
//
// Parts are numbered along a chain, and every host gets one run of them, as long as it has ranks: no assignment of all
// parts has fewer neighbours p, p + 1 on different hosts. Of the orders of hosts the one under which most particles
// stay on their host is taken, then in each run that under which most stay on their rank; ties go to the lower host or
// rank first in the run. Both exact up to 12 (dynamic programme over sets); above that hosts in the order of the mean
// place of what they hold, ranks by greed as in relabel.hpp, or natural order if that keeps more. Reproduces the
// present owners if the parts are those of now and each host holds a run of them.

#include <cstdint>
#include <span>
#include <vector>

#include "balance/load.hpp"

namespace moraine {

/// The most hosts, and ranks of a host, whose best order is searched for.
inline constexpr std::size_t most_exact_order = 12;

/// The rank of each part, every rank once. part_of[b] is the part of block b, in [0, ranks); host_of_rank as in
/// comm/host_groups.hpp. A block whose owner is not in [0, ranks) stays nowhere. Not collective.
std::vector<std::int32_t> relabel_on_hosts(std::span<const BlockLoad> blocks, std::span<const std::int32_t> part_of,
                                           std::span<const std::int32_t> host_of_rank);

/// Parts by number along the Morton curve: each by the median of its blocks, so that those of any partitioner are
/// neighbours by number where they are in space. Parts without a block come last. Not collective.
std::vector<std::int32_t> numbered_along_curve(std::vector<std::int32_t> part_of, int parts);

}  // namespace moraine
