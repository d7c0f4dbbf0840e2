#include "gpu/kernels/g2p/sort_blocks.hpp"
#include "gpu/kernels/launch.hpp"
#include "gpu/kernels/warp.cuh"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

namespace {

constexpr int sort_warps = 8, sort_threads = 32 * sort_warps;
constexpr int batch = 8;  ///< entries in flight per lane

/// Number of the list that block b belongs to; -1: there is no such block. A warp per block.
__device__ int list_of(const BlocksToSort& s, int materials, int b) {
    if (b < 0) return -1;
    const std::uint32_t begin = s.first[b], end = s.first[b + 1];
    int mine = -1;
    for (std::uint32_t base = begin; base < end; base += 32 * batch) {
        std::uint32_t at[batch];
        int material[batch];
#pragma unroll
        for (int i = 0; i < batch; ++i)  // beyond the end the last one again
            at[i] = s.slot[min(base + 32 * std::uint32_t(i) + std::uint32_t(lane_id()), end - 1)];
#pragma unroll
        for (int i = 0; i < batch; ++i) material[i] = s.body[at[i]];
#pragma unroll
        for (int i = 0; i < batch; ++i) material[i] = s.material_of[material[i]];
        if (base == begin) mine = __shfl_sync(all_lanes, material[0], 0);
        bool other = false;
#pragma unroll
        for (int i = 0; i < batch; ++i) other = other || material[i] != mine;
        if (__any_sync(all_lanes, other)) return materials;
    }
    return mine;
}

/// Puts the lanes' blocks behind their lists; list: -1 where a lane has none. A whole warp calls it.
__device__ void append(const SortedBlocks& to, int block, int list) {
    const unsigned peers = __match_any_sync(all_lanes, list);
    const int leader = __ffs(static_cast<int>(peers)) - 1;
    std::uint32_t place = 0;
    if (list >= 0 && lane_id() == leader)
        place = atomicAdd(to.growing + list, static_cast<std::uint32_t>(__popc(peers)));
    place = __shfl_sync(all_lanes, place, leader) + std::uint32_t(__popc(peers & ((1u << lane_id()) - 1)));
    if (list < 0) return;
    to.block[std::size_t(list) * to.capacity + place] = block;
    to.list_of[block] = static_cast<std::uint16_t>(list);
}

/// The last thread block to be done says how long the lists have become, so that no launch is needed that empties them.
__global__ void __launch_bounds__(sort_threads, 6)
    sort_kernel(const __grid_constant__ BlocksToSort s, const __grid_constant__ SortedBlocks to) {
    __shared__ int block[sort_warps], list[sort_warps];
    __shared__ bool last;
    const std::uint32_t count = *s.chosen.count, warp = threadIdx.x / 32;
    for (std::uint32_t base = blockIdx.x * sort_warps; base < count; base += gridDim.x * sort_warps) {
        const int b = base + warp < count ? s.chosen.block[base + warp] : -1;
        const int k = list_of(s, to.materials, b);
        if (lane_id() == 0) block[warp] = b, list[warp] = k;
        __syncthreads();
        const bool mine = lane_id() < sort_warps;
        if (warp == 0) append(to, mine ? block[lane_id()] : -1, mine ? list[lane_id()] : -1);
        __syncthreads();
    }
    std::uint32_t* done = to.growing + to.materials + 1;
    if (threadIdx.x == 0) {
        __threadfence();
        last = atomicInc(done, gridDim.x - 1) == gridDim.x - 1;
    }
    __syncthreads();
    if (!last) return;
    for (int k = static_cast<int>(threadIdx.x); k <= to.materials; k += sort_threads) {
        const std::uint32_t length = atomicExch(to.growing + k, 0u);
        to.count[k] = length;
        if (to.told) *static_cast<volatile std::uint32_t*>(to.told + k) = length;
    }
}

__global__ void __launch_bounds__(sort_threads)
    add_kernel(const Chosen limited, const __grid_constant__ SortedBlocks to) {
    const std::uint32_t count = *limited.count;
    for (std::uint32_t item = blockIdx.x * sort_threads + threadIdx.x; item < count; item += gridDim.x * sort_threads) {
        const int block = limited.block[item], rest = to.materials;
        if (to.list_of[block] == rest) continue;  // it is there
        to.block[std::size_t(rest) * to.capacity + atomicAdd(to.count + rest, 1u)] = block;
    }
}

}  // namespace

void sort_blocks(const BlocksToSort& from, const SortedBlocks& to, const Launch& launch) {
    const int grid = few_blocks((launch.blocks > 0 ? launch.blocks : 0) / sort_warps + 1);
    sort_kernel<<<static_cast<unsigned>(grid), sort_threads, 0, launch.stream>>>(from, to);
    check(cudaGetLastError(), "Sorting blocks by material");
}

void add_to_rest(const Chosen& limited, const SortedBlocks& to, const Launch& launch) {
    const int grid = few_blocks((launch.blocks > 0 ? launch.blocks : 0) / sort_threads + 1);
    add_kernel<<<static_cast<unsigned>(grid), sort_threads, 0, launch.stream>>>(limited, to);
    check(cudaGetLastError(), "Listing blocks with light nodes");
}

}  // namespace moraine::gpu
