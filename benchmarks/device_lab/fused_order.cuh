#pragma once
// The new order of a block's particles, and what is written in it.
//
// A stable sort by key: each warp has counted those of its part of the list, and every warp adds up all counts.

#include "device_lab/fused_layout.cuh"

namespace moraine::gpu::lab {

template <class Real, int Capacity, int Passes, bool Ahead>
struct FusedOrder {
    using H = Held<Real, Capacity, Passes, Ahead>;
    using Step = FusedStep<Real>;
    static constexpr unsigned threads = H::threads;

    static __device__ __forceinline__ void empty_bins(H& held) {
        auto* words = reinterpret_cast<std::uint32_t*>(held.bin);
        for (unsigned k = thread_now(); k < H::warps * bins / 2; k += threads) words[k] = 0;
    }

    /// From keys to the order; begins and ends with a barrier. Each warp adds up all counts for itself: that is less
    /// than the barriers it would take to share the work.
    static __device__ __forceinline__ void sort(std::uint32_t n, H& held) {
        static_assert(bins == 96 && bins <= 128 && H::rounds * 32 <= 512);
        __syncthreads();
        const unsigned warp = thread_now() / 32, key = 3 * unsigned(lane_id());
        std::uint32_t all[3] = {0, 0, 0}, before[3] = {0, 0, 0};
#pragma unroll
        for (unsigned w = 0; w < H::warps; ++w)
#pragma unroll
            for (int j = 0; j < 3; ++j) {
                if (w == warp) before[j] = all[j];
                all[j] += held.bin[w][key + j];
            }
        const std::uint32_t sum = all[0] + all[1] + all[2], first = scan_inclusive(sum) - sum;
        const std::uint32_t start[3] = {first, first + all[0], first + all[0] + all[1]};
#pragma unroll
        for (int j = 0; j < 3; ++j) {
            held.place[warp][key + j] = std::uint16_t(start[j] + before[j]);
            if (warp == 0) held.start[key + j] = start[j];
        }
        __syncwarp();
        for (unsigned r = 0; r < H::rounds_of(n); ++r) {
            const unsigned i = H::first_of(n) + 32 * r;
            if (i >= n) break;
            const unsigned k = held.key[i];
            held.order[held.place[warp][k & 127] + (k >> 7)] = std::uint16_t(i);
        }
        __syncthreads();
    }

    /// Rows in their new order, and who goes where.
    static __device__ __forceinline__ void write(const Step& s, int b, std::uint32_t n, const H& held) {
        const std::size_t base = std::size_t(b) * s.capacity;
        const unsigned t = thread_now();
#pragma unroll 1
        for (unsigned k = t; k < n; k += threads) {
            const unsigned i = held.order[k], at = H::at(i);
#pragma unroll
            for (int r = 0; r < core_rows<3>; ++r) store_row(s.v.p.core[r] + base + k, held.take(at, r));
            s.home[base + k] = held.home[i];
        }
        const std::uint32_t stay = held.start[first_exit];
        if (t == 0) s.region[b] = {stay, n, 0, n - stay};
        if (stay == n || t > unsigned(exits)) return;
        const std::uint32_t from = held.start[first_exit + t];
        s.exit_at[std::size_t(b) * (exits + 1) + t] = std::uint16_t(from);
        if (t >= unsigned(Block<3>::offsets) || held.start[first_exit + t + 1] == from) return;
        const int to = int(held.neighbour[t]);
        if (to >= 0) s.claimed[to] = held.number[t];  // whoever else writes it writes the same
    }
};

}  // namespace moraine::gpu::lab
