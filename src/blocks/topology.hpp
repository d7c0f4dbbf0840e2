#pragma once
// The topology of an epoch, replicated on all ranks: which blocks may be visited, and who owns them.
//
// S = occupied blocks and all their 3^d - 1 neighbours (the apron), in key order. It holds for one
// epoch: until particles may have moved 3 cells in all. A new (empty) block belongs to whom a static
// partitioner says by position, else to the owner of its first occupied neighbour in offset order.

#include <cstdint>
#include <functional>
#include <vector>

#include "blocks/block_index.hpp"
#include "core/data/block.hpp"
#include "core/data/morton.hpp"
#include "core/grid/shape.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

/// Blocks along the axes of the domain, and which axes wrap.
template <int Dim>
struct DomainBlocks {
    BlockPosition<Dim> count{};
    std::array<bool, Dim> periodic{};
    BlockPosition<Dim> nodes{};  ///< node index of the upper faces

    explicit DomainBlocks(const Scene& scene);

    /// Wraps `at` along periodic axes; false: outside the domain.
    bool wrap(BlockPosition<Dim>& at) const;
};

/// An occupied block, as all ranks know it.
struct OccupiedBlock {
    Key key;
    std::int32_t owner;
};

template <int Dim>
struct Topology {
    std::vector<Key> keys;            ///< S, sorted
    std::vector<std::int32_t> owner;  ///< of each block of S
    BlockIndex<Dim> index;            ///< of S

    /// Index in S, or -1.
    std::int64_t find(Key key) const { return index.find(key); }
};

/// `occupied` in key order, all in the domain, the same on all ranks. An empty block keeps the owner that it has in
/// `before`, if it is there; else `owner_at` gives it by position, or -1 for the neighbour rule; several threads call
/// it at a time. Not collective.
template <int Dim>
Topology<Dim> make_topology(const DomainBlocks<Dim>& domain, const std::vector<OccupiedBlock>& occupied,
                            const std::function<std::int32_t(const BlockPosition<Dim>&)>& owner_at,
                            const Topology<Dim>* before = nullptr);

}  // namespace moraine
