#pragma once
// Filing: each block's list made anew, by the rule of src/core/filing.hpp:
//   stayers in list order, then arrivals by source offset, then by source order; stable sort by cell.
//
// Light kernels, one warp per block, no atomics: (1) leavers sorted by the offset they leave through,
// stored where the block's list is long: no capacity, no scan; (2) next lengths, then one prefix sum;
// (3) the next list. The gather left one bit per list entry: it changed its cell. Only those (one in ten) are sorted,
// by rank within 32 (__match_any_sync) and running totals in shared memory; the others keep their order, so each one's
// place is its old one plus a shift of its cell minus the changed entries before it: no lane waits for another.

#include "view.cuh"

namespace lab {

/// What filing reads and writes besides the view.
struct Filing {
    std::uint32_t* leaver_slot;  ///< [list entry]: leavers of block b start at first[b]
    std::uint8_t* leaver_cell;
    std::uint32_t* leaver_first;  ///< blocks x 28: bounds per exit within the block's leavers
    std::uint32_t* next_count;    ///< blocks
    std::uint32_t* next_first;    ///< blocks + 1
    std::uint32_t* next_slot;
    std::uint32_t* next_cell_first;
};

inline constexpr int filing_warps = 4;
inline constexpr unsigned all_lanes = 0xffffffffu;

__device__ __forceinline__ int lane_id() {
    return int(threadIdx.x) & 31;
}
__device__ __forceinline__ int move_code_of(std::uint16_t m) {
    return m >> 6;
}

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

inline constexpr int group = 1024;  ///< list entries whose changed ones are gathered at a time

/// Calls f(list entry within the block, active) for the changed entries of block b in list order, 32 at a time.
template <class Real, class F>
__device__ __forceinline__ void each_changed(const View<Real>& v, int b, std::uint32_t begin, std::uint32_t count,
                                             std::uint16_t* gathered, const F& f) {
    const std::uint32_t* words = v.changed + begin / 32 + std::uint32_t(b);
    for (std::uint32_t base = 0; base < count; base += group) {
        const std::uint32_t w = base / 32 + lane_id();
        std::uint32_t bits = 32 * w < count ? words[w] : 0;
        const std::uint32_t mine = __popc(bits), upto = scan_inclusive(mine);
        const std::uint32_t n = __shfl_sync(all_lanes, upto, 31);
        for (std::uint32_t at = upto - mine; bits != 0; bits &= bits - 1)
            gathered[at++] = std::uint16_t(32 * lane_id() + __ffs(bits) - 1);
        __syncwarp();
        for (std::uint32_t j = 0; j < n; j += 32) {
            const bool active = j + lane_id() < n;
            f(base + (active ? gathered[j + lane_id()] : 0), active);
        }
        __syncwarp();
    }
}

template <class Real>
__global__ void __launch_bounds__(32 * filing_warps) collect_leavers(View<Real> v, Filing f) {
    __shared__ std::uint32_t at_all[filing_warps][32];
    __shared__ std::uint16_t gathered_all[filing_warps][group];
    const int w = int(threadIdx.x) / 32, b = int(blockIdx.x) * filing_warps + w, lane = lane_id();
    if (b >= v.blocks) return;
    std::uint32_t* at = at_all[w];
    const std::uint32_t begin = v.first[b], count = v.first[b + 1] - begin;
    at[lane] = 0;
    __syncwarp();
    each_changed(v, b, begin, count, gathered_all[w], [&](std::uint32_t e, bool active) {
        const int code = active ? move_code_of(v.moves[begin + e]) : Block<3>::centre;
        take_place(code != Block<3>::centre && code < offsets, code, at);
    });
    const std::uint32_t mine = at[lane];
    const std::uint32_t before = scan_inclusive(mine) - mine;
    if (lane <= offsets) f.leaver_first[b * exits + lane] = before;
    __syncwarp();
    at[lane] = begin + before;
    __syncwarp();
    each_changed(v, b, begin, count, gathered_all[w], [&](std::uint32_t e, bool active) {
        const std::uint16_t m = active ? v.moves[begin + e] : std::uint16_t(Block<3>::centre * 64);
        const bool leaves = move_code_of(m) != Block<3>::centre && move_code_of(m) < offsets;
        const std::uint32_t to = take_place(leaves, move_code_of(m), at);
        if (leaves) f.leaver_slot[to] = v.slot[begin + e], f.leaver_cell[to] = std::uint8_t(m & 63);
    });
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
    if (lane_id() == 0) f.next_count[b] = v.first[b + 1] - v.first[b] - f.leaver_first[b * exits + offsets] + arriving;
}

/// next_first = prefix sum of next_count: one block of 1024 threads, 32 counts per thread in flight.
static __global__ void __launch_bounds__(1024) scan_counts(int n, const std::uint32_t* count, std::uint32_t* first) {
    constexpr int rows = 8;
    __shared__ std::uint32_t warp_sum[rows][32];
    std::uint32_t carried = 0;
    const int warp = int(threadIdx.x) / 32;
    for (int base = 0; base < n; base += rows * 4096) {
        std::uint32_t c[rows][4], sum[rows], upto[rows];
#pragma unroll
        for (int r = 0; r < rows; ++r) {
            const int i = base + 4096 * r + 4 * int(threadIdx.x);
#pragma unroll
            for (int k = 0; k < 4; ++k) c[r][k] = i + k < n ? count[i + k] : 0;
        }
#pragma unroll
        for (int r = 0; r < rows; ++r) {
            sum[r] = c[r][0] + c[r][1] + c[r][2] + c[r][3];
            upto[r] = scan_inclusive(sum[r]);
            if (lane_id() == 31) warp_sum[r][warp] = upto[r];
        }
        __syncthreads();
        if (warp < rows) warp_sum[warp][lane_id()] = scan_inclusive(warp_sum[warp][lane_id()]);
        __syncthreads();
#pragma unroll
        for (int r = 0; r < rows; ++r) {
            const int i = base + 4096 * r + 4 * int(threadIdx.x);
            std::uint32_t at = carried + upto[r] - sum[r] + (warp > 0 ? warp_sum[r][warp - 1] : 0);
#pragma unroll
            for (int k = 0; k < 4; ++k) {
                if (i + k < n) first[i + k] = at;
                at += c[r][k];
            }
            carried += warp_sum[r][31];
        }
        __syncthreads();
    }
    if (threadIdx.x == 0) first[n] = carried;
}

/// Shared memory of one warp of fill_next.
struct FillScratch {
    std::uint32_t old[cells + 1];  ///< bounds of the cells in the old list
    std::uint32_t out[cells];      ///< entries that left the cell
    std::uint32_t in[2 * cells];   ///< that came into it: from lower cells; from higher ones and other blocks
    std::uint32_t shift[cells];    ///< new place - old place + changed entries before, of one that stayed in its cell
    std::uint32_t upto[32], start[32];
    std::uint16_t gathered[group];

    /// Old cell of list entry e.
    __device__ int cell_of_entry(std::uint32_t e) const {
        int c = 0;
#pragma unroll
        for (int step = 32; step > 0; step /= 2)
            if (old[c + step] <= e) c += step;
        return c;
    }
    /// Which counter of `in` an entry goes to.
    __device__ int key(std::uint32_t e, int to) const {
        return to + (cell_of_entry(e) > to ? cells : 0);
    }
};

/// From counts to places; writes the new bounds.
__device__ __forceinline__ void place_cells(FillScratch& s, std::uint32_t* next_bounds) {
    const int lane = lane_id();
    std::uint32_t stay[2], low[2], total[2], out[2];
    for (int i = 0; i < 2; ++i) {
        const int c = 2 * lane + i;
        out[i] = s.out[c], low[i] = s.in[c];
        stay[i] = s.old[c + 1] - s.old[c] - out[i];
        total[i] = low[i] + stay[i] + s.in[cells + c];
    }
    std::uint32_t at = scan_inclusive(total[0] + total[1]) - total[0] - total[1];
    std::uint32_t gone = scan_inclusive(out[0] + out[1]) - out[0] - out[1];
    __syncwarp();
    for (int i = 0; i < 2; ++i) {
        const int c = 2 * lane + i;
        s.in[c] = at, s.in[cells + c] = at + low[i] + stay[i];
        s.shift[c] = at + low[i] - s.old[c] + gone;
        next_bounds[c] = at;
        at += total[i], gone += out[i];
    }
    if (lane == 31) next_bounds[cells] = at;
    __syncwarp();
}

template <class Real>
__global__ void __launch_bounds__(32 * filing_warps) fill_next(View<Real> v, Filing f) {
    __shared__ FillScratch scratch[filing_warps];
    const int w = int(threadIdx.x) / 32, lane = lane_id();
    const int b = int(blockIdx.x) * filing_warps + w;
    if (b >= v.blocks) return;
    FillScratch& s = scratch[w];
    const std::uint32_t begin = v.first[b], count = v.first[b + 1] - begin;
    const std::uint32_t* old = v.cell_first + std::size_t(b) * bounds;
    for (int i = lane; i <= cells; i += 32) s.old[i] = old[i];
    const Arrivals a = arrivals_from(v, f, b, lane);
    s.upto[lane] = scan_inclusive(a.count);
    s.start[lane] = a.start - (s.upto[lane] - a.count);
    for (int i = lane; i < cells; i += 32) s.out[i] = s.in[i] = s.in[cells + i] = 0;
    __syncwarp();
    const std::uint32_t arriving = s.upto[31];
    const auto source = [&](std::uint32_t k) {
        int code = 0;
        while (s.upto[code] <= k) ++code;
        return s.start[code] + k;
    };
    each_changed(v, b, begin, count, s.gathered, [&](std::uint32_t e, bool active) {
        const std::uint16_t m = active ? v.moves[begin + e] : std::uint16_t(0);
        take_place(active, s.cell_of_entry(e), s.out);
        take_place(active && move_code_of(m) == Block<3>::centre, s.key(e, m & 63), s.in);
    });
    for (std::uint32_t k = 0; k < arriving; k += 32) {
        const bool in = k + lane < arriving;
        take_place(in, cells + (in ? f.leaver_cell[source(k + lane)] : 0), s.in);
    }
    place_cells(s, f.next_cell_first + std::size_t(b) * bounds);

    std::uint32_t* to = f.next_slot + f.next_first[b];
    const std::uint32_t* words = v.changed + begin / 32 + std::uint32_t(b);
    std::uint32_t before = 0;
    constexpr int batch = 8;  ///< loads in flight per lane
    for (std::uint32_t base = 0; base < count; base += 32 * batch) {
        std::uint32_t bits[batch], slot[batch];
        std::uint16_t m[batch];
#pragma unroll
        for (int i = 0; i < batch; ++i) {
            const std::uint32_t e = base + 32 * i + lane;
            bits[i] = e - lane < count ? words[base / 32 + i] : 0;
            m[i] = e < count ? v.moves[begin + e] : std::uint16_t(0);
            slot[i] = e < count ? v.slot[begin + e] : 0;
        }
#pragma unroll
        for (int i = 0; i < batch; ++i) {
            const std::uint32_t e = base + 32 * i + lane;
            const std::uint32_t to_at = e + s.shift[m[i] & 63] - before - __popc(bits[i] & ((1u << lane) - 1));
            if (e < count && !((bits[i] >> lane) & 1)) to[to_at] = slot[i];
            before += __popc(bits[i]);
        }
    }
    each_changed(v, b, begin, count, s.gathered, [&](std::uint32_t e, bool active) {
        const std::uint16_t m = active ? v.moves[begin + e] : std::uint16_t(0);
        const bool stays = active && move_code_of(m) == Block<3>::centre;
        const std::uint32_t place = take_place(stays, s.key(e, m & 63), s.in);
        if (stays) to[place] = v.slot[begin + e];
    });
    for (std::uint32_t k = 0; k < arriving; k += 32) {
        const bool in = k + lane < arriving;
        const std::uint32_t from = in ? source(k + lane) : 0;
        const std::uint32_t place = take_place(in, cells + (in ? f.leaver_cell[from] : 0), s.in);
        if (in) to[place] = f.leaver_slot[from];
    }
}

}  // namespace lab
