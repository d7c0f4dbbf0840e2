#pragma once
// 16 bytes from global into shared memory, past the registers; a thread sees its own copies after wait_async.

namespace lab {

__device__ __forceinline__ void copy_async(void* to, const void* from) {
    const auto address = static_cast<unsigned>(__cvta_generic_to_shared(to));
    asm volatile("cp.async.cg.shared.global [%0], [%1], 16;" ::"r"(address), "l"(from));
}
__device__ __forceinline__ void commit_async() { asm volatile("cp.async.commit_group;"); }
template <int N>
__device__ __forceinline__ void wait_async() {
    asm volatile("cp.async.wait_group %0;" ::"n"(N));
}

}  // namespace lab
