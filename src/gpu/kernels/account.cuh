#pragma once
// Exact sums on the device, by atomics and over a warp; gpu/kernels/seen.cuh has the rest of an Account
// (gpu/kernels/view.hpp).
//
// What is folded by atomics is an integer, so no order matters. 128 bits are two atomics: the carry out of the low word
// is known from what it was before, and high words add modulo 2^64, so only the end of the launch is a valid sum.

#include "gpu/kernels/view.hpp"
#include "gpu/kernels/warp.cuh"

namespace moraine::gpu {

__device__ __forceinline__ unsigned long long* word(std::uint64_t* p) {
    return reinterpret_cast<unsigned long long*>(p);
}

/// *to += sum. Nobody may read `to` meanwhile.
__device__ __forceinline__ void add_exact(ExactSum* to, const ExactSum& sum) {
    const std::uint64_t old = atomicAdd(word(&to->low), static_cast<unsigned long long>(sum.low));
    const std::uint64_t high = static_cast<std::uint64_t>(sum.high) + (old + sum.low < old ? 1 : 0);
    if (high != 0) atomicAdd(reinterpret_cast<unsigned long long*>(&to->high), static_cast<unsigned long long>(high));
}

/// Sum over these lanes of a warp in all of them, modulo 2^128. In pieces of 27 bits, 32 of which fit into a word.
__device__ __forceinline__ ExactSum warp_sum(const ExactSum& mine, unsigned lanes = all_lanes) {
    constexpr std::uint64_t piece = (1u << 27) - 1;
    const std::uint64_t low = mine.low, high = static_cast<std::uint64_t>(mine.high);
    const std::uint64_t bits[5] = {low & piece, (low >> 27) & piece, ((low >> 54) | (high << 10)) & piece,
                                   (high >> 17) & piece, high >> 44};
    ExactSum sum;
#pragma unroll
    for (int i = 0; i < 5; ++i) {
        const std::uint64_t s = __reduce_add_sync(lanes, static_cast<std::uint32_t>(bits[i]));
        const int at = 27 * i;
        ExactSum shifted;
        shifted.low = at < 64 ? s << at : 0;
        shifted.high = static_cast<std::int64_t>(at == 0 ? 0 : at < 64 ? s >> (64 - at) : s << (at - 64));
        sum.add(shifted);
    }
    return sum;
}

__device__ __forceinline__ std::uint64_t warp_max(std::uint64_t mine) {
    const auto high = static_cast<std::uint32_t>(mine >> 32);
    const std::uint32_t top = __reduce_max_sync(all_lanes, high);
    const std::uint32_t low = __reduce_max_sync(all_lanes, high == top ? static_cast<std::uint32_t>(mine) : 0);
    return (static_cast<std::uint64_t>(top) << 32) | low;
}
__device__ __forceinline__ std::uint64_t warp_min(std::uint64_t mine) {
    return ~warp_max(~mine);
}

/// Adds N exact sums of a warp's lanes to those at `to`, if any is not zero: 2 N atomics. Whole warps call it.
template <int N>
__device__ __forceinline__ void fold_sums(const ExactSum (&mine)[N], ExactSum* to) {
    bool zero = true;
    for (int i = 0; i < N; ++i) zero = zero && mine[i].low == 0 && mine[i].high == 0;
    if (__all_sync(all_lanes, zero)) return;
#pragma unroll
    for (int i = 0; i < N; ++i) {
        const ExactSum sum = warp_sum(mine[i]);
        if (lane_id() == i) add_exact(to + i, sum);
    }
}

/// Adds N values to the exact sums at `to`: 2 N atomics for all lanes that are here together with the same `to`. Any
/// lanes may call it.
template <int N>
__device__ __forceinline__ void add_together(ExactSum (&to)[N], const Quantum& quantum, const double (&values)[N]) {
    const unsigned lanes = __match_any_sync(__activemask(), reinterpret_cast<std::uintptr_t>(&to));
    const bool leads = lane_id() == __ffs(static_cast<int>(lanes)) - 1;
#pragma unroll
    for (int i = 0; i < N; ++i) {
        const ExactSum sum = warp_sum(quantum.of(values[i]), lanes);
        if (leads && (sum.low != 0 || sum.high != 0)) add_exact(to + i, sum);
    }
}

}  // namespace moraine::gpu
