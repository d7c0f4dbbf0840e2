#pragma once
// What the kernels of one step see of one rank's share on the device. Plain pointers, by value.
//
// Numbers of blocks, cells, tiles, corners and neighbours are those of core/data/block.hpp, tables those of
// blocks/epoch.hpp. Tiles: [tile][node of tile][2 quads]: (mass, momentum), (force, 0 or mean); node values: [node
// block][node][2 quads]: (v', 0), (dv, 0), the mass in the last lane of the first where light nodes are marked, in the
// second's what fluids want (nodes.hpp). Only occupied blocks have a tile; every node block of the epoch has node
// values.

#include "core/data/exact_sum.hpp"
#include "core/data/grid_views.hpp"
#include "core/grid/stencil.hpp"
#include "core/grid/walls.hpp"
#include "core/particles/stress.hpp"
#include "gpu/memory/particle_rows.hpp"

namespace moraine::gpu {

/// Blocks that a launch works on: the occupied ones of a list, made anew by each binning. Their number is known to the
/// device alone, so a thread block takes items blockIdx.x, + gridDim.x, ... until there are no more.
struct Chosen {
    const std::int32_t* block;
    const std::uint32_t* count;
};

/// What the particles of the step tell the step control and the budget. Folded into by integer atomics, so that no
/// order matters; a launch spreads over `account_parts` of them.
template <int Dim>
struct Account {
    std::uint64_t signal;        ///< bits of the largest c + |v| [m/s], a double that is not negative
    std::uint64_t moved;         ///< bits of the largest displacement along an axis [cells]
    std::uint64_t square_speed;  ///< bits of the largest |v|^2, with the grid's pressure [m2/s2]
    std::uint64_t faulty_id;     ///< lowest id with a fault; all ones: none
    std::uint32_t faults;
    std::uint32_t clamped;  ///< contiguous GIMP boxes held at half a cell
    ExactSum work;          ///< of the stresses
    ExactSum impulse[Dim];  ///< of walls and damping
    ExactSum lost_mass;     ///< through open walls
    ExactSum lost_momentum[Dim];
    ExactSum lost_gravity_impulse[Dim];
    std::uint64_t lost_count;
};
inline constexpr int account_parts = 64;

/// The state of the share between launches.
template <class Real, int Dim>
struct View {
    BlockTable<Dim> table;
    ListView<Dim> list;  ///< first: own + 1; cell_first: own x (cells + 1), within the block's list; slot
    TileView<Real> grid;
    Columns<Real, Dim> p;
    StencilContext<Real, Dim> context;  ///< half_size on the device, one entry per body
    std::uint16_t* moves;               ///< per list entry: encode_move (core/particles/place_step.hpp)
    std::uint32_t* changed;  ///< bit per list entry: it changed its cell or block. Words of block b: first[b] / 32 + b
    Account<Dim>* accounts;  ///< account_parts
};

}  // namespace moraine::gpu
