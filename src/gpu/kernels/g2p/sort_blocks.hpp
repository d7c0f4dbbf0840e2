#pragma once
// Which blocks are of one material: in a scene of several these go to kernels that have gather and stress in one, each
// material's to its own, and the rest by two (gpu/material_gathers.hpp).
//
// A block is of a material if all its particles are. Those with light nodes go with the rest, whatever they are of.
// Both are facts about the block in this step, so the way it goes, and its bits, are the same whoever owns it, and
// after a restart. The order of a list has no meaning.

#include <cstddef>

#include "gpu/kernels/g2p/g2p.hpp"

namespace moraine::gpu {

/// What is asked of a block: its list's slots, bodies, materials.
struct BlocksToSort {
    Chosen chosen;
    const std::uint32_t* first;        ///< ListView::first
    const std::uint32_t* slot;         ///< the lists
    const std::uint16_t* body;         ///< by slot
    const std::uint16_t* material_of;  ///< by body
};

/// One list for each material, then that of the rest.
struct SortedBlocks {
    int materials;
    std::int32_t* block;     ///< list k begins at k * capacity
    std::size_t capacity;    ///< of a list
    std::uint32_t* count;    ///< materials + 1
    std::uint32_t* growing;  ///< the same while the kernel runs, and behind them how many thread blocks are done; zero
                             ///< before and after
    std::uint16_t* list_of;  ///< own: the number of its list
    std::uint32_t* told;     ///< `count` for the host, in pinned memory; null: it does not ask

    Chosen list(int k) const { return {block + static_cast<std::size_t>(k) * capacity, count + k}; }
};

/// Sorts blocks by what their particles are of.
void sort_blocks(const BlocksToSort& from, const SortedBlocks& to, const Launch& launch);

/// Lists with the rest those of `limited` that are of one material, too: they are also in that one's list, whose kernel
/// passes them by.
void add_to_rest(const Chosen& limited, const SortedBlocks& to, const Launch& launch);

}  // namespace moraine::gpu
