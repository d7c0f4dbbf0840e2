#pragma once
// What a thread block of the fused step asks memory for: rows, nodes, and what is to be known of the next block; all by
// cp.async, so that no register waits. Groups of copies: nodes, then rounds of rows, each asked for
// a round ahead: to ask for all at once is to stand in a queue. With Ahead the first round comes before the nodes.

#include "device_lab/fused_layout.cuh"

namespace moraine::gpu::lab {

template <class Real, int Capacity, int Passes, bool Ahead>
struct FusedCopies {
    using Case = typename Held<Real, Capacity, Passes, Ahead>::Case;
    using H = Held<Real, Capacity, Passes, Ahead>;
    using Step = FusedStep<Real>;
    static constexpr unsigned threads = H::threads;

    /// Asks for the rows of one round: one group of copies, of the first round with where those who leave will go.
    static __device__ __forceinline__ void start(const Step& s, const Region& from, int b, unsigned r, H& held) {
        const std::size_t base = std::size_t(b) * s.capacity;
        const std::uint32_t n = from.count();
        const unsigned i = H::first_of(n) + r * 32;
        if (r < H::rounds_of(n) && i < n) {
            const std::size_t slot = base + from.place(i);
#pragma unroll
            for (int row = 0; row < core_rows<3>; ++row)
#pragma unroll
                for (int u = 0; u < H::per_row; ++u)
                    copy_async<16>(&held.rows.unit[row * H::per_row + u][H::at(i)],
                                   reinterpret_cast<const uint4*>(s.v.p.core[row] + slot) + u);
            copy_async<4>(&held.home[i], s.home + slot);
        }
        if (const unsigned t = thread_now(); r == 0 && t < unsigned(Block<3>::offsets)) {
            copy_async<4>(&held.neighbour[t], s.v.table.neighbour + std::size_t(b) * Block<3>::offsets + t);
            copy_async<4>(&held.number[t], s.number);
        }
        commit_async();
    }

    /// Asks for the nodes of the block, which come before the rows: one group of copies.
    static __device__ __forceinline__ void start_nodes(const View<Real, 3>& v, const std::int32_t* node_block,
                                                       typename H::Tile& tile) {
        constexpr int side = Case::side, size = int(sizeof(Real));
        auto& nodes = nodes_of(tile);
#pragma unroll 1
        for (int n = int(thread_now()); n < Case::tile_nodes; n += int(threads)) {
            int corner = 0, at = 0, rest = n;
#pragma unroll
            for (int a = 0; a < 3; ++a, rest /= side) {
                corner |= (rest % side >> 2) << a;
                at |= (rest % side & 3) << (2 * a);
            }
            const std::int32_t block = node_block[corner];  // node_of is the identity
            const Real* from = v.grid.nodes + (std::size_t(block) * Block<3>::cells + unsigned(at)) * node_reals;
            Real *row = nodes.row[n].e, *pair = nodes.pair[n].e;
            copy_async<2 * size>(row, from);
            copy_async<size>(row + 2, from + 2);
            copy_async<size>(row + 3, from + quad);
            copy_async<size>(pair, from + quad + 1);
            copy_async<size>(pair + 1, from + quad + 2);
        }
        commit_async();
    }

    /// Once they are there: ghosts and steps; ends with a barrier.
    static __device__ __forceinline__ void finish_nodes(const View<Real, 3>& v, int b, bool border,
                                                        typename H::Tile& tile) {
        wait_async<(Ahead ? 0 : 1)>();
        __syncthreads();
        if (border) set_ghosts<3>(v, b, Quadratic::origin, nodes_of(tile));
        set_steps(tile);
    }
    template <int W>
    static __device__ __forceinline__ void set_steps(NodeTile<Real, 3, W>&) {}
    template <int W>
    static __device__ __forceinline__ void set_steps(StepTile<Real, 3, W>& tile) {
        for (int n = int(thread_now()); n < tile.node.size - 1; n += int(threads)) {
            auto step = tile.node.get(n + 1);
            step.combine(tile.node.get(n), [](Real x, Real y) { return x - y; });
            tile.step.set(n, step);
        }
        __syncthreads();
    }

    /// What is to be known of the next block comes while this one is worked on, in two steps: its number, the rest.
    /// Complete after wait_async<0> of the threads that asked and a barrier.
    static __device__ __forceinline__ void ask_for_number(const Chosen& chosen, std::uint32_t item, H& held) {
        if (thread_now() == 0) {
            if (item < count_now(chosen))
                copy_async<4>(&held.next.block, chosen.block + item);
            else
                held.next.block = -1;
        }
        commit_async();
    }
    static __device__ __forceinline__ void ask_for_rest(const Step& s, H& held) {
        const unsigned t = thread_now();
        const int b = held.next.block;
        if (b >= 0 && t < 4) {
            const std::int32_t* nodes = s.v.table.node_block + std::size_t(b) * Block<3>::corners;
            if (t < 2) copy_async<16>(&held.next.node_block[4 * t], nodes + 4 * t);
            if (t == 2) copy_async<16>(&held.next.region, s.region + b);
            if (t == 3) copy_async<4>(held.next.border, s.v.table.border + (b & ~3));
        }
        commit_async();
    }
};

}  // namespace moraine::gpu::lab
