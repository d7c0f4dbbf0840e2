#pragma once
// e_i of core/fluid/particle_shifting.hpp at a node. What it lacks on a bed depends on the node above, which may be
// another block's: that one is summed from the tiles around, because all tiles that reach it are there.

#include "core/fluid/particle_shifting.hpp"
#include "gpu/kernels/nodes/node_work.hpp"
#include "gpu/kernels/nodes/tiles_around.cuh"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

/// The ground at the nodes of the node block c (gpu/kernels/gaps/gaps.cu); null: there is none.
template <int Dim>
__device__ __forceinline__ GroundNode<Dim>* ground_of_block(const ContactField<Dim>& contact, int c) {
    return contact.ground ? contact.ground + std::size_t(c) * Block<Dim>::cells : nullptr;
}

/// v / h^d of the next node along an axis, upwards or downwards, from the tiles around a node: all that reach it, but
/// for those of the block above where n is the last of its block. Whole warps call it.
template <int Width, class Real, int Dim>
__device__ __forceinline__ Real filling_beside(const Real* tiles, const TilesAround<Dim>& around, int n, int axis,
                                               int step, Real inverse_volume) {
    constexpr int side = tile_side(Width);
    Real volume = Real(0);
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const std::int32_t tile = around.tile(delta);
        bool covers = (around.there >> delta) & 1;
        int at = 0;
#pragma unroll
        for (int a = Dim - 1; a >= 0; --a) {
            const int x = ((n >> (2 * a)) & 3) + 4 * Block<Dim>::corner(delta, a) + (a == axis ? step : 0);
            covers = covers && x >= 0 && x < side;
            at = at * side + x;
        }
        if (covers) volume += tiles[(std::size_t(tile) * power<Dim>(side) + std::size_t(at) + 1) * node_reals - 1];
    }
    return volume * inverse_volume;
}

/// Whether the nodes above node n of the node block c are full, where it is on beds (core/fluid/particle_shifting.hpp).
/// Whole warps call it, in steps that shift.
template <int Width, class Real, int Dim>
__device__ __forceinline__ bool is_full_above(const View<Real, Dim>& view, const NodeCapacity<Real, Dim>& capacity,
                                              int origin, Real inverse_volume, const TilesAround<Dim>& around, int c,
                                              int n) {
    int node[Dim];
    unsigned beds = 0;
    if (c < view.table.node_blocks && view.table.node_border[c] != 0) {
#pragma unroll
        for (int a = 0; a < Dim; ++a) node[a] = 4 * view.table.node_position[c][a] - origin + ((n >> (2 * a)) & 3);
        beds = capacity.beds_at(node);
    }
    bool full = beds != 0;
    for (int bed = 0; bed < 2 * Dim; ++bed) {
        const bool on = beds >> bed & 1;
        if (!__any_sync(all_lanes, on)) continue;
        const int axis = bed / 2, step = bed % 2 == 0 ? 1 : -1;
        const Real filling = filling_beside<Width>(view.grid.tiles, around, n, axis, step, inverse_volume);
        if (on) full = full && is_full(capacity, node, axis, step, filling);
    }
    return full;
}

/// e_i of node n of the node block c whose lowest node is `lowest`. filling: v_i / h^d; full: is_full_above.
template <int Width, class Real, int Dim>
__device__ __forceinline__ Real excess_of_node(const NodeContact<Dim>& contact, const NodeCapacity<Real, Dim>& capacity,
                                               int c, int n, const int (&lowest)[Dim], const int (&node)[Dim],
                                               Real filling, bool full) {
    if (!contact.acts) {
        const SpaceNode* beside = contact.surfaces.of(c, n);
        return limits_node(beside) ? excess_beside(*beside, filling) : node_excess(filling, capacity.of(node), full);
    }
    constexpr double reach = 0.5 * Width;
    const ContactField<Dim>& field = contact.field;
    const GroundNode<Dim>* ground = ground_of_block(field, c);
    if (ground && ground[n].surface.distance < reach * field.cell) return at_structure<Real>;
    if (structure_within<false>(field, lowest, Block<Dim>::side, reach) && reaches_structure<false>(field, node, reach))
        return at_structure<Real>;
    return node_excess(filling, capacity.of(node), full);
}

}  // namespace moraine::gpu
