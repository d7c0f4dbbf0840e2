#pragma once
// Prefix sums over a thread block.

#include "gpu/kernels/warp.cuh"

namespace moraine::gpu {

inline constexpr int scan_threads = 256;

/// Sum of `mine` over the threads before this one; total: of all. All threads of the block call it.
__device__ __forceinline__ std::uint32_t scan_exclusive(std::uint32_t mine, std::uint32_t& total) {
    constexpr int warps = scan_threads / 32;
    __shared__ std::uint32_t part[warps];
    const int w = static_cast<int>(threadIdx.x) / 32;
    const std::uint32_t upto = scan_inclusive(mine);
    __syncthreads();  // the call before is done with part
    if (lane_id() == 31) part[w] = upto;
    __syncthreads();
    std::uint32_t before = 0;
    total = 0;
    for (int i = 0; i < warps; ++i) {
        if (i < w) before += part[i];
        total += part[i];
    }
    return before + upto - mine;
}

}  // namespace moraine::gpu
