#pragma once
// Threads that work on one block of particles: in 3-D a thread block of 128, in 2-D, where a block has few particles
// (16 cells), one warp of four.
//
// A team takes chosen blocks item, item + stride, ... up to a count that only the device knows, so a launch of any
// size is right. Sums over a team run in one fixed tree: they depend on the block's list alone.

#include <cstdint>

#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

template <int Dim>
struct Team {
    static constexpr int threads = Dim == 3 ? 128 : 32;
    static constexpr int per_block = Dim == 3 ? 1 : 4;  ///< teams of a thread block
    static constexpr int block_threads = threads * per_block;
    static constexpr int warps = threads / 32;

    static __device__ __forceinline__ int index() { return int(threadIdx.x) / threads; }
    static __device__ __forceinline__ int rank() { return int(threadIdx.x) % threads; }
    static __device__ __forceinline__ std::uint32_t first() { return blockIdx.x * per_block + unsigned(index()); }
    static __device__ __forceinline__ std::uint32_t stride() { return gridDim.x * per_block; }

    /// Waits for the team; what its threads wrote is seen.
    static __device__ __forceinline__ void sync() {
        if constexpr (threads == 32)
            __syncwarp();
        else
            __syncthreads();
    }

    /// The team's sum, on rank 0; with a sync(). scratch: `warps` doubles of the team, not in use.
    static __device__ __forceinline__ double sum(double x, double* scratch) {
#pragma unroll
        for (int d = 16; d > 0; d /= 2) x += __shfl_down_sync(0xffffffffu, x, d);
        if (rank() % 32 == 0) scratch[rank() / 32] = x;
        sync();
        if (rank() == 0)
            for (int w = 1; w < warps; ++w) x += scratch[w];
        return x;
    }
};

}  // namespace moraine::gpu
