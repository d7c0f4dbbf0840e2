#pragma once
// Affinity of ranks to the chain as it is owned now: every link has one home rank, and a rank's links are contiguous.
//
// Exact where each rank holds one piece of the chain. Elsewhere (blocks that the flow has just reached belong
// to a neighbour in space, not on the chain) a rank's home is around the median of what it holds, and the
// border between two homes lies where most particles of both are at home.

#include <cstdint>
#include <span>
#include <vector>

#include "balance/load.hpp"

namespace moraine {

struct OwnerAffinity {
    std::vector<std::int32_t> rank;   ///< of each home, in chain order; each rank at most once
    std::vector<std::int64_t> first;  ///< first link of each home, then the number of links
    std::vector<std::int64_t> held;   ///< of each link: particles there that its home's rank holds
};

/// link_of[b] is the link of block b, in [0, links). No home at all if no block has an owner below `ranks`.
/// Not collective.
OwnerAffinity affinity_of(std::span<const BlockLoad> blocks, std::span<const std::int32_t> link_of, std::int64_t links,
                          int ranks);

}  // namespace moraine
