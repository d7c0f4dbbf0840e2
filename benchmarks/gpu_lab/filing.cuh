#pragma once
// Filing: each block's list made anew, by the rule of src/core/filing.hpp:
//   stayers in list order, then arrivals by source offset, then by source order; stable sort by cell.
//
// Three light kernels, one warp per block, no atomics: (1) leavers sorted by the offset they leave through,
// stored where the block's list is long: no capacity, no scan; (2) next lengths, then one prefix sum;
// (3) stable counting sort: rank within 32 members by __match_any_sync, running totals per cell in shared memory.

#include "view.cuh"

namespace lab {

/// What filing reads and writes besides the view.
struct Filing {
    std::uint32_t* leaver_slot;   ///< [list entry]: leavers of block b start at first[b]
    std::uint8_t* leaver_cell;
    std::uint32_t* leaver_first;  ///< blocks x 28: bounds per exit within the block's leavers
    std::uint32_t* next_count;    ///< blocks
    std::uint32_t* next_first;    ///< blocks + 1
    std::uint32_t* next_slot;
    std::uint32_t* next_cell_first;
};

inline constexpr int filing_warps = 4;
inline constexpr unsigned all_lanes = 0xffffffffu;

__device__ __forceinline__ int lane_id() { return int(threadIdx.x) & 31; }
__device__ __forceinline__ int move_code_of(std::uint16_t m) { return m >> 6; }

/// Adds up `mine` over the lanes below; total in the last lane.
__device__ __forceinline__ std::uint32_t scan_inclusive(std::uint32_t mine) {
#pragma unroll
    for (int d = 1; d < 32; d *= 2) {
        const std::uint32_t other = __shfl_up_sync(all_lanes, mine, d);
        if (lane_id() >= d) mine += other;
    }
    return mine;
}

/// Place of each lane with `mine` after those of equal value below it; advances at[value].
__device__ __forceinline__ std::uint32_t take_place(bool active, int value, std::uint32_t* at) {
    const unsigned peers = __match_any_sync(all_lanes, active ? value : -1);
    const int rank = __popc(peers & ((1u << lane_id()) - 1));
    std::uint32_t place = 0;
    if (active) place = at[value] + std::uint32_t(rank);
    __syncwarp();
    if (active && rank == 0) at[value] += std::uint32_t(__popc(peers));
    __syncwarp();
    return place;
}

template <class Real>
__global__ void __launch_bounds__(32 * filing_warps) collect_leavers(View<Real> v, Filing f) {
    __shared__ std::uint32_t at_all[filing_warps][32];
    std::uint32_t* at = at_all[threadIdx.x / 32];
    const int b = int(blockIdx.x) * filing_warps + int(threadIdx.x) / 32;
    if (b >= v.blocks) return;
    const int lane = lane_id();
    const std::uint32_t begin = v.first[b], end = v.first[b + 1];
    at[lane] = 0;
    __syncwarp();
    bool any = false;
#pragma unroll 4
    for (std::uint32_t k = begin; k < end; k += 32) {
        const bool in = k + lane < end;
        const int code = in ? move_code_of(v.moves[k + lane]) : Block<3>::centre;
        const bool leaves = code != Block<3>::centre && code < offsets;
        if (__ballot_sync(all_lanes, leaves) == 0) continue;
        any = true;
        take_place(leaves, code, at);
    }
    const std::uint32_t count = at[lane];
    const std::uint32_t before = scan_inclusive(count) - count;
    if (lane <= offsets) f.leaver_first[b * exits + lane] = before;
    if (!any) return;
    __syncwarp();
    at[lane] = begin + before;
    __syncwarp();
    for (std::uint32_t k = begin; k < end; k += 32) {
        const bool in = k + lane < end;
        const std::uint16_t m = in ? v.moves[k + lane] : std::uint16_t(Block<3>::centre * 64);
        const int code = move_code_of(m);
        const bool leaves = code != Block<3>::centre && code < offsets;
        if (__ballot_sync(all_lanes, leaves) == 0) continue;
        const std::uint32_t to = take_place(leaves, code, at);
        if (leaves) f.leaver_slot[to] = v.slot[k + lane], f.leaver_cell[to] = std::uint8_t(m & 63);
    }
}

/// Lane `code` of a warp: the arrivals from that neighbour.
struct Arrivals {
    std::uint32_t start;
    std::uint32_t count;
};

template <class Real>
__device__ __forceinline__ Arrivals arrivals_from(const View<Real>& v, const Filing& f, int b, int code) {
    Arrivals a{0, 0};
    if (code >= offsets || code == Block<3>::centre) return a;
    const int from = v.neighbour[b * offsets + code];
    if (from < 0) return a;
    const std::uint32_t* exit = f.leaver_first + from * exits + Block<3>::opposite(code);
    a.start = v.first[from] + exit[0];
    a.count = exit[1] - exit[0];
    return a;
}

template <class Real>
__global__ void __launch_bounds__(32 * filing_warps) count_next(View<Real> v, Filing f) {
    const int b = int(blockIdx.x) * filing_warps + int(threadIdx.x) / 32;
    if (b >= v.blocks) return;
    const Arrivals a = arrivals_from(v, f, b, lane_id());
    const std::uint32_t arriving = __reduce_add_sync(all_lanes, a.count);
    if (lane_id() == 0)
        f.next_count[b] = v.first[b + 1] - v.first[b] - f.leaver_first[b * exits + offsets] + arriving;
}

/// next_first = prefix sum of next_count: one block of 1024 threads, each a stretch.
static __global__ void __launch_bounds__(1024) scan_counts(int n, const std::uint32_t* count, std::uint32_t* first) {
    __shared__ std::uint32_t warp_sum[32];
    __shared__ std::uint32_t carried;
    if (threadIdx.x == 0) carried = 0;
    __syncthreads();
    for (int base = 0; base < n; base += 4096) {
        const int i = base + 4 * int(threadIdx.x);
        std::uint32_t c[4], sum = 0;
        for (int k = 0; k < 4; ++k) c[k] = i + k < n ? count[i + k] : 0, sum += c[k];
        const std::uint32_t upto = scan_inclusive(sum);
        if (lane_id() == 31) warp_sum[threadIdx.x / 32] = upto;
        __syncthreads();
        if (threadIdx.x < 32) warp_sum[lane_id()] = scan_inclusive(warp_sum[lane_id()]);
        __syncthreads();
        std::uint32_t at = carried + upto - sum + (threadIdx.x >= 32 ? warp_sum[threadIdx.x / 32 - 1] : 0);
        for (int k = 0; k < 4; ++k) {
            if (i + k < n) first[i + k] = at;
            at += c[k];
        }
        __syncthreads();
        if (threadIdx.x == 1023) carried = at;
        __syncthreads();
    }
    if (threadIdx.x == 0) first[n] = carried;
}

template <class Real>
__global__ void __launch_bounds__(32 * filing_warps) fill_next(View<Real> v, Filing f) {
    __shared__ std::uint32_t at_all[filing_warps][cells];
    __shared__ std::uint32_t upto_all[filing_warps][32];
    __shared__ std::uint32_t start_all[filing_warps][32];
    const int w = int(threadIdx.x) / 32, lane = lane_id();
    const int b = int(blockIdx.x) * filing_warps + w;
    if (b >= v.blocks) return;
    std::uint32_t *at = at_all[w], *upto = upto_all[w], *start = start_all[w];
    const std::uint32_t begin = v.first[b], end = v.first[b + 1];
    const Arrivals a = arrivals_from(v, f, b, lane);
    upto[lane] = scan_inclusive(a.count);
    start[lane] = a.start - (upto[lane] - a.count);
    at[lane] = at[lane + 32] = 0;
    __syncwarp();
    const std::uint32_t arriving = upto[31];
    const auto source = [&](std::uint32_t k) {
        int code = 0;
        while (upto[code] <= k) ++code;
        return start[code] + k;
    };
    const auto stay = [&](std::uint32_t k) {
        return k < end ? v.moves[k] : std::uint16_t(0);
    };
#pragma unroll 4
    for (std::uint32_t k = begin; k < end; k += 32) {
        const std::uint16_t m = stay(k + lane);
        take_place(move_code_of(m) == Block<3>::centre, m & 63, at);
    }
    for (std::uint32_t k = 0; k < arriving; k += 32)
        take_place(k + lane < arriving, k + lane < arriving ? f.leaver_cell[source(k + lane)] : 0, at);

    const std::uint32_t low = at[2 * lane], high = at[2 * lane + 1];
    const std::uint32_t before = scan_inclusive(low + high) - low - high;
    __syncwarp();
    at[2 * lane] = before, at[2 * lane + 1] = before + low;
    std::uint32_t* to_first = f.next_cell_first + std::size_t(b) * bounds;
    to_first[2 * lane] = before, to_first[2 * lane + 1] = before + low;
    if (lane == 31) to_first[cells] = before + low + high;
    __syncwarp();

    std::uint32_t* to = f.next_slot + f.next_first[b];
#pragma unroll 4
    for (std::uint32_t k = begin; k < end; k += 32) {
        const std::uint16_t m = stay(k + lane);
        const bool stays = move_code_of(m) == Block<3>::centre;
        const std::uint32_t slot = stays ? v.slot[k + lane] : 0;
        const std::uint32_t place = take_place(stays, m & 63, at);
        if (stays) to[place] = slot;
    }
    for (std::uint32_t k = 0; k < arriving; k += 32) {
        const bool in = k + lane < arriving;
        const std::uint32_t s = in ? source(k + lane) : 0;
        const std::uint32_t place = take_place(in, in ? f.leaver_cell[s] : 0, at);
        if (in) to[place] = f.leaver_slot[s];
    }
}

/// Column `from` in list order; the lists become 0, 1, 2, ...
template <class T>
__global__ void __launch_bounds__(256) permute(std::uint32_t n, const std::uint32_t* slot, const T* from, T* to) {
    const std::uint32_t k = blockIdx.x * 256 + threadIdx.x;
    if (k >= n) return;
    if constexpr (sizeof(T) >= 16)
        store_row(to + k, load_row(from + slot[k]));
    else
        to[k] = from[slot[k]];
}
static __global__ void __launch_bounds__(256) count_up(std::uint32_t n, std::uint32_t* slot) {
    const std::uint32_t k = blockIdx.x * 256 + threadIdx.x;
    if (k < n) slot[k] = k;
}

}  // namespace lab
