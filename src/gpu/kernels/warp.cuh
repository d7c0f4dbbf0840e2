#pragma once
// What the 32 lanes of a warp do together: sums, places of equal values, rows of 16 or 32 bytes.

#include <cstdint>

namespace moraine::gpu {

inline constexpr unsigned all_lanes = 0xffffffffu;

__device__ __forceinline__ int lane_id() {
    return static_cast<int>(threadIdx.x) & 31;
}

/// Adds up `mine` over this lane and those below; the total is in the last lane.
__device__ __forceinline__ std::uint32_t scan_inclusive(std::uint32_t mine) {
#pragma unroll
    for (int d = 1; d < 32; d *= 2) {
        const std::uint32_t other = __shfl_up_sync(all_lanes, mine, static_cast<unsigned>(d));
        if (lane_id() >= d) mine += other;
    }
    return mine;
}

/// Place of each active lane behind those of equal value below it; advances at[value], which is in shared memory.
__device__ __forceinline__ std::uint32_t take_place(bool active, int value, std::uint32_t* at) {
    const unsigned peers = __match_any_sync(all_lanes, active ? value : -1);
    const unsigned rank = static_cast<unsigned>(__popc(peers & ((1u << lane_id()) - 1)));
    std::uint32_t place = 0;
    if (active) place = at[value] + rank;
    __syncwarp();
    if (active && rank == 0) at[value] += static_cast<std::uint32_t>(__popc(peers));
    __syncwarp();
    return place;
}

/// One row by accesses of 16 bytes.
template <class T>
__device__ __forceinline__ T load_row(const T* from) {
    static_assert(sizeof(T) % sizeof(uint4) == 0);
    T row;
    const uint4* f = reinterpret_cast<const uint4*>(from);
    uint4* t = reinterpret_cast<uint4*>(&row);
#pragma unroll
    for (int i = 0; i < static_cast<int>(sizeof(T) / sizeof(uint4)); ++i) t[i] = f[i];
    return row;
}
template <class T>
__device__ __forceinline__ void store_row(T* to, const T& row) {
    static_assert(sizeof(T) % sizeof(uint4) == 0);
    uint4* t = reinterpret_cast<uint4*>(to);
    const uint4* f = reinterpret_cast<const uint4*>(&row);
#pragma unroll
    for (int i = 0; i < static_cast<int>(sizeof(T) / sizeof(uint4)); ++i) t[i] = f[i];
}

}  // namespace moraine::gpu
