#pragma once
// Memory refresh: columns in list order, one at a time; afterwards the lists are 0, 1, 2, ...

#include "view.cuh"

namespace lab {

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
