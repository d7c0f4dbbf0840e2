#pragma once
// The kernel of gpu/kernels/nodes/nodes.hpp: a thread per node, 4 (3-D) or 16 (2-D) node blocks per thread block. Node
// blocks near structures have an instance and a launch of their own (near_blocks.hpp).
//
// Bound by memory. A warp looks up the tiles around its nodes once; a thread then knows by bits which of them are there
// and cover its node.

#include "gpu/kernels/account.cuh"
#include "gpu/kernels/nodes/excess.cuh"
#include "gpu/kernels/nodes/following.cuh"
#include "gpu/kernels/nodes/node_work.hpp"
#include "gpu/kernels/nodes/tiles_around.cuh"

namespace moraine::gpu {

inline constexpr int node_threads = 256;

/// Calls f(c) with the node block of this thread, in whole warps; table.node_blocks: there is none. Contact: those near
/// a structure, by their list. Else: all others.
template <bool Contact, int Dim, class F>
__device__ __forceinline__ void each_node_block(const BlockTable<Dim>& table, const NearBlocks& near, const F& f) {
    constexpr int blocks = node_threads / Block<Dim>::cells;
    const int mine = static_cast<int>(threadIdx.x) / Block<Dim>::cells;
    if constexpr (Contact) {
        const int count = static_cast<int>(*near.count);
        for (int first = static_cast<int>(blockIdx.x) * blocks; first < count;
             first += static_cast<int>(gridDim.x) * blocks)
            f(first + mine < count ? near.list[first + mine] : table.node_blocks);
    } else {
        const int c = static_cast<int>(blockIdx.x) * blocks + mine;
        const bool skipped = near.mark && c < table.node_blocks && near.mark[c] != 0;
        f(skipped ? table.node_blocks : c);
    }
}

/// P_i or e_i of a node of the node block c; total: s_i.
template <int Width, bool Contact, class Real, int Dim>
__device__ __forceinline__ Real mean_of_node(const FluidNodeWork<Real, Dim>& w, int c, int n, const int (&node)[Dim],
                                             Real mass, Real total, bool full) {
    const bool solid = mass > w.round.mass_cutoff;
    if (!w.fluid.shifts) return solid ? total / mass : Real(0);
    const Real filling = solid ? total * w.fluid.inverse_volume : Real(0);
    if constexpr (Contact) {
        int lowest[Dim];
#pragma unroll
        for (int a = 0; a < Dim; ++a) lowest[a] = 4 * w.view.table.node_position[c][a] - w.origin;
        return excess_of_node<Width>(w.contact, w.fluid.capacity, c, n, lowest, node, filling, full);
    }
    return node_excess(filling, w.fluid.capacity.of(node), full);
}

/// Where the values of node n of a node block are.
template <class Real, int Dim>
__device__ __forceinline__ Quad<Real>* values_of_node(const View<Real, Dim>& v, int c, int n) {
    return reinterpret_cast<Quad<Real>*>(v.grid.nodes) + (std::size_t(c) * Block<Dim>::cells + std::size_t(n)) * 2;
}

/// One node: its values after a round, and what damping and walls gave it if it is counted here. node: its index, set.
template <int Width, bool Contact, class Real, int Dim>
__device__ __forceinline__ NodeValues<Real, Dim> advance_node(const NodeWork<Real, Dim>& w, int c, int n,
                                                              const Quad<Real>& sums, const Quad<Real>& force,
                                                              const NodeValues<Real, Dim>& former, bool counted,
                                                              int (&node)[Dim], ExactSum (&impulse)[Dim]) {
    const bool border = w.view.table.node_border[c] != 0;
    const bool counting = counts(w.round.task) && counted;
#pragma unroll
    for (int a = 0; a < Dim; ++a) node[a] = 4 * w.view.table.node_position[c][a] - w.origin + ((n >> (2 * a)) & 3);
    NodeMotion<Real, Dim> motion;
    Vec<double, Dim> given = zero_vec<double, Dim>();  // to structures
    if constexpr (Contact) {
        const ContactField<Dim>& field = w.contact.field;
        GroundNode<Dim>* ground = ground_of_block(field, c);
        motion = move_node(w.round, w.view.context.walls, sums, force, former, border ? node : nullptr, [&](auto& v) {
            const auto gap_of = [&](int k) {
                return gap_at_node(w.contact.gaps, w.view.table, w.view.grid.tile_of, Width, c, n, k);
            };
            const auto tell = [&](int k, const auto& values, const auto& following) {
                if (counting) add_together(field.sums[k].sum, w.quantum, values);
                if constexpr (may_turn)
                    if (counting && field.structure[k].turns) tell_following(field, k, w.quantum, following());
            };
            return w.contact.acts && touch_structures(field, node, sums[0], w.round.contact_time(), gap_of, tell, v,
                                                      given, ground ? ground + n : nullptr);
        });
    } else {
        motion = move_node(w.round, w.view.context.walls, sums, force, former, border ? node : nullptr);
    }
    if ((border || w.round.damping > Real(0)) && counting)
        for (int a = 0; a < Dim; ++a)
            impulse[a] = w.quantum.of(motion.impulse(sums[0], a) + (Contact ? given[a] : 0.0));
    return values_after(w.round.task, motion, former);
}

template <int Width, bool Contact, bool Marks, bool Fluid, class Real, int Dim>
__device__ __forceinline__ void solve_node(const NodeWorkOf<Real, Dim, Fluid>& w, int c, int n, const Quad<Real>& sums,
                                           const Quad<Real>& force, bool counted, bool full, ExactSum (&impulse)[Dim]) {
    Quad<Real>* out = values_of_node(w.view, c, n);
    NodeValues<Real, Dim> former{};
    if (remembers(w.round.task)) {
        const Quad<Real> first = load_row(out), second = load_row(out + 1);
#pragma unroll
        for (int a = 0; a < Dim; ++a) former.first[a] = first[a], former.second[a] = second[a];
    }
    int node[Dim];
    const NodeValues<Real, Dim> now =
        advance_node<Width, Contact, Real, Dim>(w, c, n, sums, force, former, counted, node, impulse);
    Quad<Real> first = Quad<Real>::zero(), second = Quad<Real>::zero();
#pragma unroll
    for (int a = 0; a < Dim; ++a) first[a] = now.first[a], second[a] = now.second[a];
    if constexpr (Marks) first[quad - 1] = sums[0];
    if constexpr (Fluid) second[quad - 1] = mean_of_node<Width, Contact>(w, c, n, node, sums[0], force[quad - 1], full);
    store_row(out, first);
    store_row(out + 1, second);
}

/// Whole warps call it.
template <class Real, int Dim>
__device__ __forceinline__ void mark_light(const LightMarks<Real>& marks, int c, int node_blocks, int n, Real mass) {
    constexpr int lanes = TilesAround<Dim>::lanes;
    const unsigned light = __ballot_sync(all_lanes, !(mass >= marks.mass));
    const int lane = lane_id();
    if (lane % lanes != 0 || c >= node_blocks) return;
    constexpr unsigned mine = lanes == 32 ? all_lanes : (1u << lanes % 32) - 1;
    marks.of[c * light_marks<Dim> + n / 32] = (light >> lane & mine) != 0;
}

/// Marks: light nodes are marked, and masses left for the gather; where fluids want more, only if they are asked for.
/// Three thread blocks of a multiprocessor: without a
/// number, and with four, the compiler spilled a register or two.
template <class Real, int Dim, int Width, bool Contact, bool Marks, bool Fluid>
__global__ void __launch_bounds__(node_threads, Contact ? 1 : (Marks ? 3 : 0))
    nodes_kernel(const __grid_constant__ NodeWorkOf<Real, Dim, Fluid> w) {
    each_node_block<Contact>(w.view.table, w.contact.near, [&](int c) {
        const int n = static_cast<int>(threadIdx.x) % Block<Dim>::cells;
        const TilesAround<Dim> around(w.view.table, w.view.grid.tile_of, c);
        const bool marks = Marks && (!Fluid || w.marks.of);
        if (marks && c == 0 && n < light_counts) w.marks.count[n] = 0;
        if (__all_sync(all_lanes, !around.wanted(w.view.table, c))) return;
        Quad<Real> sums, force;
        const bool counted = sum_tiles<Dim, Width>(w.view.grid.tiles, around, n, sums, force);
        ExactSum impulse[Dim];
        if constexpr (Marks)
            if (marks) mark_light<Real, Dim>(w.marks, c, w.view.table.node_blocks, n, sums[0]);
        bool full = false;
        if constexpr (Fluid)
            full = w.fluid.shifts &&
                   is_full_above<Width>(w.view, w.fluid.capacity, w.origin, w.fluid.inverse_volume, around, c, n);
        if (around.wanted(w.view.table, c))
            solve_node<Width, Contact, Marks, Fluid, Real, Dim>(w, c, n, sums, force, counted, full, impulse);
        fold_sums(impulse, w.view.accounts[blockIdx.x % account_parts].impulse);
    });
}

}  // namespace moraine::gpu
