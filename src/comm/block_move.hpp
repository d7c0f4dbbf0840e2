#pragma once
// Block moves: whole blocks travel to their new owners when the partition changes.
//
// A block travels in list order with all columns, so its list is the same wherever it lands.

#include <cstdint>
#include <vector>

#include "blocks/patch.hpp"
#include "comm/comm.hpp"

namespace moraine {

struct BlockMoveCount {
    std::int64_t particles = 0;  ///< sent by this rank
    std::int64_t blocks = 0;
};

/// Sends the blocks of `mine` to the ranks owner[i] and returns what this rank has then, keys ascending.
/// Blocks of one key that come from several ranks are joined in rank order. Collective.
template <class Space, class Real, int Dim>
BinnedBlocks move_blocks(const Comm& comm, Patch<Space, Real, Dim>& patch, const BinnedBlocks& mine,
                         const std::vector<std::int32_t>& owner, BlockMoveCount& moved);

}  // namespace moraine
