#pragma once
// What a step asks of sleepers between nodes and gather: the kernel of hold_sleepers() in gpu/kernels/sleep/sleep.hpp.

#include "gpu/kernels/sleep/sleep.cuh"

namespace moraine::gpu {

template <int Dim>
__global__ void __launch_bounds__(sleep_threads, 1)
    kept_awake_kernel(const BlockTable<Dim> table, const __grid_constant__ ContactField<Dim> field, const double window,
                      std::uint8_t* kept_awake) {
    const int b = static_cast<int>(blockIdx.x * sleep_threads + threadIdx.x);
    if (b < table.own) kept_awake[b] = is_kept_awake(field, window, table.position[b]);
}

/// The sum over a warp, in all lanes and in one fixed order.
__device__ __forceinline__ double sum_of_warp(double x) {
#pragma unroll
    for (int d = 16; d > 0; d /= 2) x += __shfl_xor_sync(all_lanes, x, d);
    return x;
}

/// Whether a sleeper has a fast node. If not, what its nodes would have given it is taken. Whole warps call it.
template <class Real, int Dim>
__device__ __forceinline__ bool has_fast_node(const View<Real, Dim>& v, const SleepView<Dim>& s,
                                              const HoldArgs<Real>& h, int b) {
    constexpr int corners = Block<Dim>::corners;
    const std::int32_t* node_block = v.table.node_block + std::size_t(b) * corners;
    const bool still = h.still_nodes && lane_id() < corners && !(h.near && h.near[node_block[lane_id()]]) &&
                       has_tiles_of_sleepers_alone(v.table, v.grid.tile_of, s.asleep, node_block[lane_id()]);
    const unsigned still_corners = __ballot_sync(all_lanes, still);
    const int side = tile_side(h.width), nodes = power<Dim>(side);
    const std::size_t first = std::size_t(v.grid.tile_of[b]) * std::size_t(nodes);
    HeldByNodes<Dim> held;
    bool fast = false;
    for (int n = lane_id(); n < nodes; n += 32) {
        const Real m = h.masses ? h.masses[first + n] : v.grid.tiles[(first + n) * node_reals];
        if (!(m > Real(0))) continue;
        const CornerNode node = corner_node<Dim>(n, side);
        const std::size_t stored = std::size_t(node_block[node.corner]) * Block<Dim>::cells + std::size_t(node.at);
        held.fast = false;
        held.add(s.rule, static_cast<double>(m), v.grid.nodes + stored * node_reals);
        fast = fast || (held.fast && !((still_corners >> node.corner) & 1));
    }
    if (__any_sync(all_lanes, fast)) return true;
    ExactSum* taken = s.accounts[blockIdx.x % account_parts].taken;
    for (int i = 0; i <= Dim; ++i) {
        const double sum = sum_of_warp(i == 0 ? held.kinetic : held.momentum[i == 0 ? 0 : i - 1]);
        if (lane_id() == 0) add_exact(taken + i, h.quantum.of(sum));
    }
    return false;
}

/// All of a block stay in their cells.
template <class Real, int Dim>
__device__ __forceinline__ void stay(const View<Real, Dim>& v, int b) {
    const std::uint32_t begin = v.list.first[b], count = v.list.count(b);
    const std::uint32_t* bounds = v.list.cell_first + std::size_t(b) * (Block<Dim>::cells + 1);
    for (int c = lane_id(); c < Block<Dim>::cells; c += 32)
        for (std::uint32_t k = bounds[c]; k < bounds[c + 1]; ++k)
            v.moves[begin + k] = encode_move(Block<Dim>::centre, c);
    std::uint32_t* words = v.changed + begin / 32 + static_cast<std::uint32_t>(b);
    for (std::uint32_t w = static_cast<std::uint32_t>(lane_id()); 32 * w < count; w += 32) words[w] = 0;
}

/// Others ask meanwhile who sleeps, so who wakes is marked by its particles alone. Eight thread blocks of a
/// multiprocessor: without a number the compiler took 32 registers in 3-D, and spilled.
template <class Real, int Dim>
__global__ void __launch_bounds__(sleep_threads, 8)
    hold_kernel(const __grid_constant__ View<Real, Dim> v, const __grid_constant__ SleepView<Dim> s,
                const __grid_constant__ HoldArgs<Real> h, const __grid_constant__ AwakeLists lists) {
    if (blockIdx.x == 0 && threadIdx.x < 2) *lists.of[threadIdx.x].emptied = 0;
    const int b = static_cast<int>(warp_number());
    if (b >= v.table.own || v.grid.tile_of[b] < 0) return;
    const bool asleep = s.asleep[b] != 0, kept_awake = s.kept_awake && s.kept_awake[b] != 0;
    if (asleep && !kept_awake && !has_fast_node(v, s, h, b)) {
        stay(v, b);
        if (lane_id() == 0) raise(account_of(v).signal, s.wave[b]);
        return;
    }
    if (asleep) wake_particles(v, s, b);
    const ListToMake& list = lists.of[lists.boundary[b] ? 0 : 1];
    if (lane_id() == 0) list.block[atomicAdd(list.count, 1u)] = b;
}

}  // namespace moraine::gpu
