#pragma once
// The kernels of gpu/memory/refresh.hpp. Bound by memory: a thread has four units of at most 16 bytes under way.

#include <cstddef>
#include <cstdint>

namespace moraine::gpu {

inline constexpr unsigned refresh_threads = 256;
inline constexpr unsigned refresh_batch = 4;

/// Rows of `Units` units.
template <class Unit, unsigned Units>
__global__ void __launch_bounds__(refresh_threads)
    permute_kernel(std::uint32_t n, const std::uint32_t* __restrict__ slot, const Unit* __restrict__ from,
                   Unit* __restrict__ to) {
    const std::uint32_t first = blockIdx.x * (refresh_threads * refresh_batch) + threadIdx.x;
    const std::uint32_t end = n * Units;
    std::uint32_t source[refresh_batch];
    Unit unit[refresh_batch];
#pragma unroll
    for (unsigned i = 0; i < refresh_batch; ++i) {
        const std::uint32_t k = first + i * refresh_threads;
        source[i] = k < end ? slot[k / Units] : 0;
    }
#pragma unroll
    for (unsigned i = 0; i < refresh_batch; ++i) {
        const std::uint32_t k = first + i * refresh_threads;
        if (k < end) unit[i] = from[std::size_t(source[i]) * Units + k % Units];
    }
#pragma unroll
    for (unsigned i = 0; i < refresh_batch; ++i) {
        const std::uint32_t k = first + i * refresh_threads;
        if (k < end) to[k] = unit[i];
    }
}

static __global__ void __launch_bounds__(refresh_threads)
    renumber_kernel(std::uint32_t blocks, std::uint32_t words, const std::int32_t* __restrict__ old,
                    const std::uint32_t* __restrict__ from, std::uint32_t* __restrict__ to) {
    const std::uint32_t k = blockIdx.x * refresh_threads + threadIdx.x;
    if (k >= blocks * words) return;
    const std::int32_t b = old[k / words];
    if (b >= 0) to[k] = from[std::size_t(b) * words + k % words];
}

static __global__ void __launch_bounds__(refresh_threads)
    number_kernel(std::uint32_t n, std::uint32_t* slot, std::uint32_t start) {
    const std::uint32_t k = blockIdx.x * refresh_threads + threadIdx.x;
    if (k < n) slot[k] = start + k;
}

}  // namespace moraine::gpu
