#pragma once
// Rows by 16-byte accesses, and rows on their way: copied from global into the thread's own shared memory (cp.async),
// past the registers and without a barrier, while the thread works on the particle before.
//
// The latency of memory is hidden, and a row takes registers only where it is used: measured against loads when needed
// 1.10 -> 0.93 ms for 16.8 M particles (benchmarks/device/results.md). A thread sees its own copies after wait_async.

#include <cstdint>

#include "gpu/memory/particle_rows.hpp"

namespace moraine::gpu {

/// Copies `Bytes` (4, 8 or 16) from global into shared memory.
template <int Bytes>
__device__ __forceinline__ void copy_async(void* to, const void* from) {
    const auto address = static_cast<unsigned>(__cvta_generic_to_shared(to));
    if constexpr (Bytes == 16)
        asm volatile("cp.async.cg.shared.global [%0], [%1], 16;" ::"r"(address), "l"(from) : "memory");
    else
        asm volatile("cp.async.ca.shared.global [%0], [%1], %2;" ::"r"(address), "l"(from), "n"(Bytes) : "memory");
}
__device__ __forceinline__ void commit_async() {
    asm volatile("cp.async.commit_group;" ::: "memory");
}
/// Until all but the N youngest groups have arrived.
template <int N>
__device__ __forceinline__ void wait_async() {
    asm volatile("cp.async.wait_group %0;" ::"n"(N) : "memory");
}

template <class Real>
__device__ __forceinline__ Row<Real> load_row(const Row<Real>* from) {
    Row<Real> row;
#pragma unroll
    for (int i = 0; i < int(sizeof(row) / 16); ++i)
        reinterpret_cast<uint4*>(&row)[i] = reinterpret_cast<const uint4*>(from)[i];
    return row;
}
template <class Real>
__device__ __forceinline__ void store_row(Row<Real>* to, const Row<Real>& row) {
#pragma unroll
    for (int i = 0; i < int(sizeof(row) / 16); ++i)
        reinterpret_cast<uint4*>(to)[i] = reinterpret_cast<const uint4*>(&row)[i];
}

/// Two particles' rows per thread of a team: one in use, one on its way. Units of 16 bytes, [half][unit][thread], so
/// that a warp's accesses have no bank conflicts. Scalars: single reals of the same particles.
template <class Real, int Rows, int Scalars, int Threads>
struct RowsAhead {
    static constexpr int per_row = int(sizeof(Row<Real>) / 16), units = Rows * per_row;
    uint4 unit[2][units][Threads];
    Real scalar[2][Scalars > 0 ? Scalars : 1][Scalars > 0 ? Threads : 1];

    __device__ __forceinline__ void start(int half, int thread, int r, const Row<Real>* from) {
#pragma unroll
        for (int u = 0; u < per_row; ++u)
            copy_async<16>(&unit[half][r * per_row + u][thread], reinterpret_cast<const uint4*>(from) + u);
    }
    __device__ __forceinline__ void start_scalar(int half, int thread, int i, const Real* from) {
        copy_async<int(sizeof(Real))>(&scalar[half][i][thread], from);
    }
    __device__ __forceinline__ Row<Real> take(int half, int thread, int r) const {
        Row<Real> row;
#pragma unroll
        for (int u = 0; u < per_row; ++u) reinterpret_cast<uint4*>(&row)[u] = unit[half][r * per_row + u][thread];
        return row;
    }
};

}  // namespace moraine::gpu
