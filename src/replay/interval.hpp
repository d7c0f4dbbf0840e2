#pragma once
// One imbalance check as a replay knows it: the occupied blocks, and how owners come over from the imbalance check
// before.
//
// A block that was there keeps its owner. One that is new belongs to whom a static partitioner says by position,
// else to the owner of its first neighbour, in offset order, that has one (DESIGN of epochs); a block with no such
// neighbour waits until one is known, and an island takes the owner of the block before it on the Morton curve. A real
// run may pass through several epochs between two imbalance checks, so this is its rule but not always its result.

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "balance/partitioner.hpp"
#include "balance/weight.hpp"

namespace moraine {

struct Interval {
    std::int64_t step = 0;
    double exchanges = 1;              ///< of the halo per step, since the imbalance check before
    std::vector<BlockLoad> blocks;     ///< in key order; each forecast sets their weights and owners
    std::vector<std::uint8_t> asleep;  ///< of each block; empty: all are awake

    /// Particles of a block by what they cost.
    std::int64_t load(std::size_t b) const {
        const std::int64_t particles = blocks[b].particles;
        return load_of(particles, !asleep.empty() && asleep[b] != 0 ? particles : 0);
    }
    /// The same of the blocks of each rank. Not collective.
    std::vector<std::int64_t> loads(std::span<const std::int32_t> owners, int ranks) const;
};

/// Of blocks of now: where each comes from. The same for every partition.
struct Carry {
    std::vector<std::int32_t> from;  ///< block of the imbalance check before, or -1: new
    std::vector<std::pair<std::int32_t, std::int32_t>>
        inheriting;  ///< new block, block of now that it follows; in order

    /// Owners of now. Not collective.
    std::vector<std::int32_t> owners(std::span<const std::int32_t> before, const Interval& now, const Layout& layout,
                                     const Partitioner& partitioner) const;
};

/// Not collective.
Carry carry_between(const Layout& layout, std::span<const Key> before, std::span<const BlockLoad> now);

/// Not collective.
std::vector<Key> keys_of(std::span<const BlockLoad> blocks);

/// The block at neighbour offset `code` of the one with this key; false: outside the domain. Not collective.
bool neighbour_key(const Layout& layout, Key key, int code, Key& result);

/// Number of neighbour offsets, the centre included: 9 or 27.
inline int offsets_of(const Layout& layout) {
    return layout.dimensions == 2 ? 9 : 27;
}

}  // namespace moraine
