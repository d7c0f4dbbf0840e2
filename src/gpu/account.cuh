#pragma once
// How threads fold what they saw into an Account (gpu/view.hpp): exact sums, largest values, faults.
//
// Everything that is folded by atomics is an integer, or the bits of a double that is not negative, so that no order
// matters. The one sum of doubles, the work of a block's stresses, runs over one thread block in a fixed tree and is
// rounded before it is added: it depends on the kernel's number of threads, never on the size of the grid.

#include "gpu/view.hpp"
#include "gpu/warp.cuh"

namespace moraine::gpu {

__device__ __forceinline__ unsigned long long* word(std::uint64_t* p) {
    return reinterpret_cast<unsigned long long*>(p);
}

/// *to += sum. 128 bits in two words: the low one tells the carry. Nobody may read `to` meanwhile.
__device__ __forceinline__ void add_exact(ExactSum* to, const ExactSum& sum) {
    const std::uint64_t old = atomicAdd(word(&to->low), static_cast<unsigned long long>(sum.low));
    const std::uint64_t high = static_cast<std::uint64_t>(sum.high) + (old + sum.low < old ? 1 : 0);
    if (high != 0) atomicAdd(reinterpret_cast<unsigned long long*>(&to->high), static_cast<unsigned long long>(high));
}

/// Sum over the warp in all its lanes, modulo 2^128. In pieces of 27 bits, 32 of which fit into a word.
__device__ __forceinline__ ExactSum warp_sum(const ExactSum& mine) {
    constexpr std::uint64_t piece = (1u << 27) - 1;
    const std::uint64_t low = mine.low, high = static_cast<std::uint64_t>(mine.high);
    const std::uint64_t bits[5] = {low & piece, (low >> 27) & piece, ((low >> 54) | (high << 10)) & piece,
                                   (high >> 17) & piece, high >> 44};
    ExactSum sum;
#pragma unroll
    for (int i = 0; i < 5; ++i) {
        const std::uint64_t s = __reduce_add_sync(all_lanes, static_cast<std::uint32_t>(bits[i]));
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

/// What a thread's particles tell the step control; no value may be negative or not a number.
template <class Real>
struct Outcome {
    Real signal = 0;  ///< largest c + |v| [m/s]
    Real moved = 0;   ///< largest displacement along an axis [cells]
    std::uint32_t faults = 0;
    std::uint32_t clamped = 0;                   ///< contiguous GIMP boxes held at half a cell
    std::uint64_t offender = ~std::uint64_t(0);  ///< lowest id with a fault

    __device__ void fault(std::uint32_t bit, std::uint64_t id) {
        faults |= bit;
        if (id < offender) offender = id;
    }
};

/// Once per thread, after all its particles of a launch. Whole warps call it; at most two atomics per warp while
/// nothing goes wrong, and none once another warp has told of as much.
template <class Real, int Dim>
__device__ __forceinline__ void fold_outcome(const Outcome<Real>& mine, Account<Dim>* to) {
    const auto bits = [](Real v) { return static_cast<std::uint64_t>(__double_as_longlong(static_cast<double>(v))); };
    const std::uint64_t signal = warp_max(bits(mine.signal));
    const std::uint64_t moved = warp_max(bits(mine.moved));
    const std::uint32_t faults = __reduce_or_sync(all_lanes, mine.faults);
    const std::uint32_t clamped = __reduce_add_sync(all_lanes, mine.clamped);
    const std::uint64_t offender = faults ? warp_min(mine.offender) : ~std::uint64_t(0);
    if (lane_id() != 0) return;
    if (signal > to->signal) atomicMax(word(&to->signal), static_cast<unsigned long long>(signal));
    if (moved > to->moved) atomicMax(word(&to->moved), static_cast<unsigned long long>(moved));
    if (clamped) atomicAdd(&to->clamped, clamped);
    if (!faults) return;
    atomicOr(&to->faults, faults);
    atomicMin(word(&to->offender), static_cast<unsigned long long>(offender));
}

/// Once per block of cells: `mine` is the work of the thread's particles [J], summed in their order. All threads call
/// it; two barriers.
template <int Threads, int Dim>
__device__ __forceinline__ void fold_work(double mine, const Quantum& quantum, Account<Dim>* to) {
    constexpr int warps = Threads / 32;
    __shared__ double part[warps];
#pragma unroll
    for (int d = 16; d > 0; d /= 2) mine += __shfl_down_sync(all_lanes, mine, static_cast<unsigned>(d));
    if (lane_id() == 0) part[threadIdx.x / 32] = mine;
    __syncthreads();
    if (threadIdx.x == 0) {
        double sum = part[0];
        for (int w = 1; w < warps; ++w) sum += part[w];
        add_exact(&to->work, quantum.of(sum));
    }
    __syncthreads();
}

}  // namespace moraine::gpu
