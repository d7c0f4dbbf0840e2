#pragma once
// Particle to grid by thread blocks that stay: while one block's cells are combined and its tile is written, the
// records of the next are on their way. Best for doubles (two thread blocks per multiprocessor), not for floats.

#include "p2g_slices.cuh"

namespace lab {

/// Bounds of one cell's list.
struct CellList {
    std::uint32_t begin, count;
};

template <class Real>
__device__ __forceinline__ CellList list_of(const View<Real>& v, int item, int cell) {
    if (item >= v.blocks) return {0, 0};
    const int b = v.chosen(item, v.blocks);
    const std::uint32_t* at = v.cell_first + std::size_t(b) * bounds + cell;
    const std::uint32_t from = at[0], to = at[1];
    return {v.first[b] + from, to - from};
}

/// The records of rounds 0 .. Stages - 2, on their way.
template <class Real, int Stages, bool Stress>
__device__ __forceinline__ void start_rounds(const View<Real>& v, const CellList& list, int k, int cell,
                                             uint4* shared) {
    using R = StagedRecord<Real>;
    std::uint32_t s[Stages - 1];
#pragma unroll
    for (int r = 0; r < Stages - 1; ++r) s[r] = 3u * r + k < list.count ? v.slot[list.begin + 3u * r + k] : none;
#pragma unroll
    for (int r = 0; r < Stages - 1; ++r) {
        if (s[r] != none) R::template start<Stress>(v.p, s[r], shared + r * R::round_units + k * cells + cell);
        commit_async();
    }
}

/// Sums over all rounds; the first Stages - 1 have been started. All threads of the block take part.
template <class Real, int Stages, bool Momentum, bool Force>
__device__ __forceinline__ void sum_rounds(const View<Real>& v, const CellList& list, int rounds, int k, int cell,
                                           uint4* shared, SliceSums<Real>& sums) {
    using R = StagedRecord<Real>;
    clear<Real, Momentum, Force>(sums);
    const auto slot_of = [&](int r) {
        const std::uint32_t l = 3 * std::uint32_t(r) + k;
        return l < list.count ? v.slot[list.begin + l] : none;
    };
    std::uint32_t next = slot_of(Stages - 1);
    for (int r = 0; r < rounds; ++r) {
        wait_async<Stages - 2>();
        __syncthreads();
        const int ahead = r + Stages - 1;
        if (next != none)
            R::template start<Force>(v.p, next, shared + ahead % Stages * R::round_units + k * cells + cell);
        commit_async();
        next = slot_of(ahead + 1);
        const std::uint32_t done = 3 * std::uint32_t(r);
        if (list.count > done)
            sum_round<Real, Momentum, Force>(shared + r % Stages * R::round_units, cell, list.count - done, k,
                                             v.inverse_cell, sums);
    }
    __syncthreads();
    middle_from_sums<Real, Momentum, Force>(sums);
}

template <class Real, int Stages>
constexpr int resident_bytes() {
    return Stages * StagedRecord<Real>::round_units * 16 + all_planes_bytes<Real> + 7 * tile_nodes * int(sizeof(Real));
}

/// Resident thread blocks go through the list of blocks; while one's cells are combined and its tile is written, the
/// records of the next are on their way. Passes: 1 all seven sums at once, 2 momentum first, then force (doubles).
template <class Real, int Stages, int Passes, int MinBlocks>
__global__ void __launch_bounds__(192, MinBlocks) p2g_resident(const __grid_constant__ View<Real> v) {
    extern __shared__ uint4 shared[];
    __shared__ std::uint32_t most[2][6];
    Real* planes = reinterpret_cast<Real*>(shared + Stages * StagedRecord<Real>::round_units);
    const int cell = int(threadIdx.x) & 63, k = int(threadIdx.x) >> 6, warp = int(threadIdx.x) >> 5;
    CellList list = list_of(v, int(blockIdx.x), cell);
    start_rounds<Real, Stages, Passes == 1>(v, list, k, cell, shared);
    int turn = 0;
    for (int item = int(blockIdx.x); item < v.blocks; item += int(gridDim.x), turn ^= 1) {
        const std::uint32_t warp_most = __reduce_max_sync(0xffffffffu, list.count);
        if ((threadIdx.x & 31) == 0) most[turn][warp] = warp_most;
        const CellList after = list_of(v, item + int(gridDim.x), cell);
        __syncthreads();
        const int rounds = (int(max(most[turn][0], most[turn][1])) + 2) / 3;
        SliceSums<Real> sums;
        if constexpr (Passes == 2) {
            sum_rounds<Real, Stages, true, false>(v, list, rounds, k, cell, shared, sums);
            start_rounds<Real, Stages, true>(v, list, k, cell, shared);
            add_to_planes<Real, true, false>(sums, k, cell, planes);
            sum_rounds<Real, Stages, false, true>(v, list, rounds, k, cell, shared, sums);
        } else {
            sum_rounds<Real, Stages, true, true>(v, list, rounds, k, cell, shared, sums);
        }
        start_rounds<Real, Stages, Passes == 1>(v, after, k, cell, shared);
        add_to_planes<Real, Passes == 1, true>(sums, k, cell, planes);
        __syncthreads();
        if (rounds > 0) write_tile(v, v.chosen(item, v.blocks), planes, planes + planes_reals<Real>);
        list = after;
    }
}

}  // namespace lab
