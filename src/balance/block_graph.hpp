#pragma once
// The occupied blocks as a graph: an edge joins blocks whose tiles share nodes, which are the neighbours by
// face, edge and corner (also across a periodic axis).
//
// Its weight is the number of nodes that the two tiles share, per axis w - 1 where the blocks lie side by side
// and 4 + w - 1 where they do not (w: width of the stencil): what the halo sends if they have different owners.

#include <cstdint>
#include <span>
#include <vector>

#include "balance/load.hpp"

namespace moraine {

struct BlockGraph {
    std::vector<std::int64_t> first;      ///< of each block its first edge; then the number of edges
    std::vector<std::int32_t> neighbour;  ///< the block at the other end; each edge stands at both ends
    std::vector<std::int32_t> shared;     ///< nodes
};

/// `blocks` in key order. Not collective.
BlockGraph graph_of(const Layout& layout, std::span<const BlockLoad> blocks);

}  // namespace moraine
