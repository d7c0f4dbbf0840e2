#pragma once
// The light kernels of binning (gpu/kernels/binning/binning.hpp): outgoing particles, counts, places. The lists are
// filled in gpu/kernels/binning/fill_lists.cuh.
//
// Outgoing particles: a warp per occupied block. Only the changed entries, one in ten, are looked at: a rank within 32
// and running totals in shared memory put them in order. Counts and places: a thread per own block.

#include "core/particles/place_step.hpp"
#include "gpu/kernels/binning/binning.hpp"
#include "gpu/kernels/binning/changed_entries.cuh"

namespace moraine::gpu {

inline constexpr int binning_warps = 4;

__device__ __forceinline__ int binning_warp() {
    return static_cast<int>(threadIdx.x) / 32;
}

/// The occupied blocks as one list, boundary ones first, of which a warp takes every so-many-th.
class OccupiedItems {
  public:
    __device__ explicit OccupiedItems(const OccupiedBlocks& blocks, Part part = Part::all)
        : blocks_(blocks),
          boundary_(blocks.count[0]),
          begin_(part == Part::interior ? boundary_ : 0),
          all_(boundary_ + (part == Part::boundary ? 0 : blocks.count[1])) {}

    __device__ std::uint32_t first() const { return begin_ + blockIdx.x * binning_warps + threadIdx.x / 32; }
    static __device__ std::uint32_t step() { return gridDim.x * binning_warps; }

    /// Block of an item; -1: there is no such item.
    __device__ int block(std::uint32_t item) const {
        if (item >= all_) return -1;
        return item < boundary_ ? blocks_.boundary[item] : blocks_.interior[item - boundary_];
    }

  private:
    const OccupiedBlocks& blocks_;
    std::uint32_t boundary_, begin_, all_;
};

template <int Dim>
__device__ __forceinline__ int exit_of(std::uint16_t move) {
    const int code = move_code(move);
    return code == Block<Dim>::gone ? Block<Dim>::offsets : code;
}

/// Lists block b's outgoing particles. at: 32 counters of this warp.
template <int Dim>
__device__ __forceinline__ void collect_block(const Binning<Dim>& f, int b, std::uint32_t* at,
                                              std::uint16_t* gathered) {
    constexpr int stays = Block<Dim>::centre;
    const int lane = lane_id();
    const std::uint32_t begin = f.list.first[b], count = f.list.first[b + 1] - begin;
    const std::uint16_t* moves = f.moves + begin;
    const std::uint32_t* slot = f.list.slot + begin;
    ChangedEntries changed(f.changed + begin / 32 + static_cast<std::uint32_t>(b), count, gathered);
    at[lane] = 0;
    __syncwarp();
    changed.each([&](std::uint32_t e, bool active) {
        const int exit = active ? exit_of<Dim>(moves[e]) : stays;
        if (exit != stays) atomicAdd(&at[exit], 1u);
    });
    __syncwarp();
    const std::uint32_t mine = at[lane];
    const std::uint32_t upto = scan_inclusive(mine), before = upto - mine;
    if (lane == 31) f.outgoing.count[b] = upto;
    if (!__any_sync(all_lanes, mine > 0)) return;
    if (lane < outgoing_bounds<Dim>)
        f.outgoing.bound[std::size_t(b) * outgoing_bounds<Dim> + std::size_t(lane)] = before;
    at[lane] = begin + before;
    __syncwarp();
    changed.each([&](std::uint32_t e, bool active) {
        const std::uint16_t m = active ? moves[e] : encode_move(stays, 0);
        const bool leaves = exit_of<Dim>(m) != stays;
        const std::uint32_t to = take_place(leaves, exit_of<Dim>(m), at);
        if (leaves) f.outgoing.slot[to] = slot[e], f.outgoing.cell[to] = std::uint8_t(move_cell(m));
    });
}

template <int Dim>
__global__ void __launch_bounds__(32 * binning_warps)
    collect_kernel(const __grid_constant__ Binning<Dim> f, Part part) {
    __shared__ std::uint32_t at[binning_warps][32];
    __shared__ std::uint16_t gathered[binning_warps][ChangedEntries::span];
    const auto threads = static_cast<int>(gridDim.x * blockDim.x);
    for (int b = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x); part != Part::interior && b < f.table.own;
         b += threads)
        if (f.list.first[b + 1] == f.list.first[b]) f.outgoing.count[b] = 0;
    const OccupiedItems items(f.occupied, part);
    std::uint32_t item = items.first();
    for (int b = items.block(item); b >= 0;) {
        const int next = items.block(item += OccupiedItems::step());
        collect_block(f, b, at[binning_warp()], gathered[binning_warp()]);
        b = next;
    }
}

/// Bounds of the outgoing particles of block `from` that come to its neighbour, which sees it at offset `code`.
template <int Dim>
__device__ __forceinline__ const std::uint32_t* exit_towards(const Binning<Dim>& f, int from, int code) {
    return f.outgoing.bound + std::size_t(from) * outgoing_bounds<Dim> + std::size_t(Block<Dim>::opposite(code));
}

/// Length of block b's next list. Where nobody comes from it takes the difference of a number and itself: without
/// branches all loads are under way at once.
template <int Dim>
__device__ __forceinline__ std::uint32_t next_length(const Binning<Dim>& f, int b) {
    constexpr int offsets = Block<Dim>::offsets;
    const std::int32_t* neighbour = f.table.neighbour + std::size_t(b) * offsets;
    std::int32_t from[offsets];
    bool outgoing[offsets];
#pragma unroll
    for (int code = 0; code < offsets; ++code) from[code] = code == Block<Dim>::centre ? -1 : neighbour[code];
#pragma unroll
    for (int code = 0; code < offsets; ++code) outgoing[code] = from[code] >= 0 && f.outgoing.count[from[code]] > 0;
    std::uint32_t n = f.list.first[b + 1] - f.list.first[b] - f.outgoing.count[b];
#pragma unroll
    for (int code = 0; code < offsets; ++code) {
        const std::uint32_t* exit = outgoing[code] ? exit_towards(f, from[code], code) : f.list.first;
        if (code != Block<Dim>::centre) n += exit[outgoing[code] ? 1 : 0] - exit[0];
    }
    return n;
}

__device__ __forceinline__ std::uint32_t sum_of(const std::uint32_t* part, int parts) {
    std::uint32_t sum = 0;
    for (int w = 0; w < parts; ++w) sum += part[w];
    return sum;
}

/// Lengths of the next lists, or of the present ones, for now in next_first; and each chunk's tally.
template <int Dim, bool Moving>
__global__ void __launch_bounds__(binning_chunk) count_kernel(const __grid_constant__ Binning<Dim> f) {
    constexpr int warps = binning_chunk / 32;
    __shared__ std::uint32_t part[3][warps];
    const int b = static_cast<int>(blockIdx.x) * binning_chunk + static_cast<int>(threadIdx.x);
    std::uint32_t n = 0;
    bool boundary = false;
    if (b < f.table.own) {
        n = Moving ? next_length(f, b) : f.list.first[b + 1] - f.list.first[b];
        boundary = f.boundary[b] != 0;
        f.next_first[b] = n;
    }
    const std::uint32_t particles = __reduce_add_sync(all_lanes, n);
    const unsigned outer = __ballot_sync(all_lanes, n > 0 && boundary);
    const unsigned inner = __ballot_sync(all_lanes, n > 0 && !boundary);
    if (lane_id() == 0) {
        part[0][binning_warp()] = particles;
        part[1][binning_warp()] = static_cast<std::uint32_t>(__popc(outer));
        part[2][binning_warp()] = static_cast<std::uint32_t>(__popc(inner));
    }
    __syncthreads();
    if (threadIdx.x == 0)
        f.tally[blockIdx.x] = {sum_of(part[0], warps), sum_of(part[1], warps), sum_of(part[2], warps)};
}

/// From lengths to places, of lists and of blocks. A thread block adds up the tallies before its own: there is one per
/// 256 blocks, and reading them takes less time than launching a scan over them.
template <int Dim>
__global__ void __launch_bounds__(binning_chunk) place_kernel(const __grid_constant__ Binning<Dim> f) {
    constexpr int warps = binning_chunk / 32;
    __shared__ std::uint32_t before[3][warps], here[3][warps];
    const int w = binning_warp();
    const int b = static_cast<int>(blockIdx.x) * binning_chunk + static_cast<int>(threadIdx.x);
    Tally sum{0, 0, 0};
    for (unsigned c = threadIdx.x; c < blockIdx.x; c += binning_chunk) {
        const Tally t = f.tally[c];
        sum = {sum.particles + t.particles, sum.boundary + t.boundary, sum.interior + t.interior};
    }
    const bool mine = b < f.table.own;
    const std::uint32_t n = mine ? f.next_first[b] : 0;
    const bool boundary = mine && f.boundary[b] != 0;
    const unsigned outer = __ballot_sync(all_lanes, n > 0 && boundary);
    const unsigned inner = __ballot_sync(all_lanes, n > 0 && !boundary);
    const std::uint32_t upto = scan_inclusive(n);
    sum.particles = __reduce_add_sync(all_lanes, sum.particles);
    sum.boundary = __reduce_add_sync(all_lanes, sum.boundary);
    sum.interior = __reduce_add_sync(all_lanes, sum.interior);
    if (lane_id() == 31) {
        before[0][w] = sum.particles, before[1][w] = sum.boundary, before[2][w] = sum.interior;
        here[0][w] = upto;
        here[1][w] = static_cast<std::uint32_t>(__popc(outer)), here[2][w] = static_cast<std::uint32_t>(__popc(inner));
    }
    __syncthreads();
    const unsigned below = (1u << lane_id()) - 1;
    const std::uint32_t first = sum_of(before[0], warps) + sum_of(here[0], w) + upto - n;
    const std::uint32_t at[2] = {
        sum_of(before[1], warps) + sum_of(here[1], w) + static_cast<std::uint32_t>(__popc(outer & below)),
        sum_of(before[2], warps) + sum_of(here[2], w) + static_cast<std::uint32_t>(__popc(inner & below))};
    if (mine) {
        f.next_first[b] = first;
        f.occupied.tile_of[b] = n > 0 ? f.first_tile + static_cast<std::int32_t>(at[0] + at[1]) : -1;
        if (n > 0) (boundary ? f.occupied.boundary[at[0]] : f.occupied.interior[at[1]]) = b;
    }
    if (b == max(f.table.own - 1, 0)) {
        f.next_first[f.table.own] = first + n;
        const std::uint32_t count[2] = {at[0] + (n > 0 && boundary ? 1 : 0), at[1] + (n > 0 && !boundary ? 1 : 0)};
        const bool fit = count[0] + count[1] <= f.occupied.tiles;
        for (int k = 0; k < 2; ++k) f.occupied.count[k] = count[k], f.occupied.served[k] = fit ? count[k] : 0;
        *f.occupied.in_guard_layer = 0;
    }
}

}  // namespace moraine::gpu
