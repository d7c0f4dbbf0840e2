#pragma once
// 16 bytes from global into shared memory, past the registers; a thread sees its own copies after wait_async.

#include "view.cuh"

namespace lab {

__device__ __forceinline__ void copy_async(void* to, const void* from) {
    const auto address = static_cast<unsigned>(__cvta_generic_to_shared(to));
    asm volatile("cp.async.cg.shared.global [%0], [%1], 16;" ::"r"(address), "l"(from));
}
__device__ __forceinline__ void commit_async() {
    asm volatile("cp.async.commit_group;");
}
template <int N>
__device__ __forceinline__ void wait_async() {
    asm volatile("cp.async.wait_group %0;" ::"n"(N));
}

/// Asks for `bytes` (a multiple of 16) from global memory to be brought into L2; nobody waits.
__device__ __forceinline__ void prefetch(const void* from, std::uint32_t bytes) {
    if (bytes > 0) asm volatile("cp.async.bulk.prefetch.L2.global [%0], %1;" ::"l"(from), "r"(bytes));
}

/// One thread asks for the rows of a block that will run soon. Right while the memory order is fresh (slot = place in
/// the list); when it is stale some of it is fetched in vain, and the answer is the same.
template <class Real>
__device__ __forceinline__ void prefetch_block(const View<Real>& v, int item) {
    if (item >= v.blocks) return;
    const int b = v.chosen(item, v.blocks);
    const std::uint32_t from = v.first[b], n = v.first[b + 1] - from, row = n * 4 * std::uint32_t(sizeof(Real));
    const std::uint32_t aligned = from / 4 * 4;
    prefetch(v.slot + aligned, (from + n - aligned) / 4 * 16);
    prefetch(v.p.place + from, row), prefetch(v.p.motion + from, row);
    prefetch(v.p.normal + from, row), prefetch(v.p.shear + from, row);
}

}  // namespace lab
