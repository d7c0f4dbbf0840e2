#pragma once
// Sums of a node over the tiles around it, by warps: the order is that of core/nodes/nodes.hpp.

#include "core/data/block.hpp"
#include "core/data/grid_views.hpp"
#include "core/data/quad.hpp"
#include "gpu/kernels/warp.cuh"

namespace moraine::gpu {

/// The tiles around a node block: each warp looks them up, a lane each, for the one or two node blocks of its nodes.
template <int Dim>
struct TilesAround {
    static constexpr int corners = Block<Dim>::corners;
    static constexpr int lanes = Block<Dim>::cells < 32 ? Block<Dim>::cells : 32;  ///< of a node block

    std::int32_t mine;  ///< tile at offset delta in lane delta of the node block's lanes
    unsigned there;     ///< bit delta: the block has a tile
    unsigned own;       ///< and it is an own one

    __device__ TilesAround(const BlockTable<Dim>& table, const std::int32_t* tile_of, int c) {
        const int delta = lane_id() % lanes;
        const bool asks = delta < corners && c < table.node_blocks;
        const std::int32_t source = asks ? table.source[std::size_t(c) * corners + std::size_t(delta)] : -1;
        mine = source < 0 ? -1 : tile_of[source];
        const int first = lane_id() - delta;
        const unsigned bits = (1u << corners) - 1;
        there = (__ballot_sync(all_lanes, mine >= 0) >> first) & bits;
        own = (__ballot_sync(all_lanes, mine >= 0 && source < table.own) >> first) & bits;
    }

    /// Whether this rank wants the node block c: for particles of its own, or by table.kept_nodes.
    __device__ bool wanted(const BlockTable<Dim>& table, int c) const {
        return own != 0 || (table.kept_nodes && there != 0 && table.kept_nodes[c] >= 0);
    }
    /// Whether the first of the tiles that cover node n is an own one.
    __device__ bool first_is_own(int n, int width) const {
        unsigned covering = 0;
#pragma unroll
        for (int delta = 0; delta < corners; ++delta)
            covering |= unsigned(tile_node<Dim>(n, delta, width) >= 0) << delta;
        const unsigned candidates = there & covering;
        return ((candidates & -candidates) & own) != 0;
    }
    /// Whole warps call it.
    __device__ std::int32_t tile(int delta) const {
        return __shfl_sync(all_lanes, mine, delta, lanes);
    }
};

/// Sums of node n over the tiles around it. Returns whether the first of them is an own one. Whole warps call it.
template <int Dim, int Width, class Real>
__device__ __forceinline__ bool sum_tiles(const Real* tiles, const TilesAround<Dim>& around, int n, Quad<Real>& sums,
                                          Quad<Real>& force) {
    constexpr int side = tile_side(Width);
    sums = force = Quad<Real>::zero();
    unsigned layers = 0;  // axes along which the tile of a lower block reaches the node
    int at = 0;
#pragma unroll
    for (int a = Dim - 1; a >= 0; --a) {
        const int x = (n >> (2 * a)) & 3;
        at = at * side + x;
        layers |= (x < Width - 1 ? 1u : 0u) << a;
    }
    constexpr int tiles_at_once = 16 / sizeof(Real);  // loads in flight: more of them were slower in double
    int counted_by = -1;
#pragma unroll
    for (int group = 0; group < Block<Dim>::corners; group += tiles_at_once) {
        Quad<Real> m[tiles_at_once], f[tiles_at_once];
        bool covers[tiles_at_once];
#pragma unroll
        for (int i = 0; i < tiles_at_once; ++i) {
            const int delta = group + i;
            const std::int32_t tile = around.tile(delta);
            covers[i] = ((around.there >> delta) & 1) && !(static_cast<unsigned>(delta) & ~layers);
            int shift = 0;
            for (int a = Dim - 1; a >= 0; --a) shift = shift * side + 4 * Block<Dim>::corner(delta, a);
            const Real* from = tiles + (std::size_t(tile) * power<Dim>(side) + std::size_t(at + shift)) * node_reals;
            if (!covers[i]) continue;
            m[i] = load_row(reinterpret_cast<const Quad<Real>*>(from));
            f[i] = load_row(reinterpret_cast<const Quad<Real>*>(from) + 1);
        }
#pragma unroll
        for (int i = 0; i < tiles_at_once; ++i) {
            if (!covers[i]) continue;
            sums = sums + m[i];
            force = force + f[i];
            if (counted_by < 0) counted_by = group + i;
        }
    }
    return counted_by >= 0 && ((around.own >> counted_by) & 1);
}

}  // namespace moraine::gpu
