#pragma once
// A warp per block of particles, as the kernels of sleep have it.

#include "gpu/kernels/view.hpp"
#include "gpu/kernels/warp.cuh"

namespace moraine::gpu {

inline constexpr unsigned sleep_threads = 128;
inline constexpr unsigned sleep_warps = sleep_threads / 32;

/// Number of this warp in the launch.
__device__ __forceinline__ unsigned warp_number() {
    return blockIdx.x * sleep_warps + threadIdx.x / 32;
}

/// Calls f(slot) for the particles of block b, each on a lane.
template <int Dim, class F>
__device__ __forceinline__ void each_slot(const ListView<Dim>& list, int b, const F& f) {
    const std::uint32_t end = list.first[b + 1];
    for (std::uint32_t k = list.first[b] + static_cast<std::uint32_t>(lane_id()); k < end; k += 32) f(list.slot[k]);
    __syncwarp();
}

}  // namespace moraine::gpu
