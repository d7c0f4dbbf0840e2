#pragma once
// Binning on the device: each block's list made anew, by the rule of core/grid/binning.hpp and to the same lists.
//
//   new list = stayers in list order, then incoming particles by source offset, then by source order; stable sort by
//   cell
//
// In two calls, so that outgoing particles of ghost blocks may come from other ranks in between. Outgoing particles are
// sorted by the exit that they take and stand where their block's list is long: no capacity, no count ahead. The same
// prefix sum that places the lists also numbers the occupied blocks, in block order, apart for boundary and interior.
// Work goes to occupied blocks only; of an empty one a thread looks at the neighbours' counts of outgoing particles.

#include <cuda_runtime.h>

#include "core/data/grid_views.hpp"

namespace moraine::gpu {

/// Exits of a block: the offset codes and, last, `gone`. Bounds of the exits within a block's outgoing particles: one
/// more.
template <int Dim>
inline constexpr int outgoing_bounds = Block<Dim>::offsets + 2;

/// Who leaves which block, by exit, in list order. Own outgoing particles start where their block's list starts, those
/// of a ghost where `ghost_start` says; whoever received them wrote them, their number and, if there are any, their
/// bounds.
struct Outgoing {
    std::uint32_t* slot;
    std::uint8_t* cell;    ///< next cell
    std::uint32_t* count;  ///< own + ghosts
    std::uint32_t*
        bound;  ///< (own + ghosts) x outgoing_bounds, from the first outgoing particle; means nothing at count 0
    const std::uint32_t* ghost_start;  ///< ghosts; at first[own] or behind
};

/// The blocks that hold particles: what a step's kernels run over.
struct OccupiedBlocks {
    std::int32_t* tile_of;          ///< own: storage index of the block's tile; -1: empty
    std::int32_t* boundary;         ///< those that some peer needs, in block order: capacity for all
    std::int32_t* interior;         ///< the others
    std::uint32_t* count;           ///< 2: how many of boundary, of interior
    std::uint32_t* served;          ///< 2: the same, or none while there are more of them than tiles
    std::uint32_t tiles;            ///< of own blocks that there is capacity for
    std::uint32_t* in_guard_layer;  ///< 1: some particle is in a cell of the guard layer
};

/// Sums over a chunk of blocks.
struct Tally {
    std::uint32_t particles, boundary, interior;
};
inline constexpr int binning_chunk = 256;
constexpr int binning_chunks(int own) {
    return own > 0 ? (own + binning_chunk - 1) / binning_chunk : 1;
}

template <int Dim>
struct Binning {
    BlockTable<Dim> table;
    ListView<Dim> list;            ///< of the step that was
    const std::uint16_t* moves;    ///< of all list entries: encode_move (core/particles/place_step.hpp)
    const std::uint32_t* changed;  ///< bit per list entry: another cell or block. Words of block b: first[b] / 32 + b
    const std::uint8_t* boundary;  ///< own: 1 where some peer needs the tile, 0 elsewhere; for an epoch
    const std::uint64_t* guard_layer;  ///< own: bit per cell (blocks/guard_layer.hpp)
    int first_tile;                    ///< storage indices of tiles below are taken
    Outgoing outgoing;
    OccupiedBlocks occupied;    ///< of the old lists; made anew in place
    std::uint32_t* cell_first;  ///< list.cell_first; made anew in place. Means nothing in an empty block
    std::uint32_t* next_first;  ///< own + 1
    std::uint32_t* next_slot;   ///< capacity for all particles that there will be
    Tally* tally;               ///< binning_chunks(own)
};

/// Occupied blocks of the present lists, at the start of an epoch.
template <int Dim>
void number_blocks(const Binning<Dim>& binning, cudaStream_t stream);

/// Which own blocks.
enum class Part { all, boundary, interior };

/// Outgoing particles of own blocks, by the moves of the step; `blocks`: about how many. What a peer needs is there
/// once those of the boundary are: empty blocks belong to it here.
template <int Dim>
void collect_outgoing(const Binning<Dim>& binning, Part part, int blocks, cudaStream_t stream);

/// The next lists, once the outgoing particles of ghosts stand behind the own ones. The caller then swaps first and
/// slot.
template <int Dim>
void make_lists(const Binning<Dim>& binning, cudaStream_t stream);

}  // namespace moraine::gpu
