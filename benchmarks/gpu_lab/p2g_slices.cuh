#pragma once
// Particle to grid, the winner's family: one thread per (cell, slice), sums in registers, private tiles.
//
// p2g_staged: rounds of three particles per cell are copied into shared memory by cp.async (each thread one
//   record), `Stages` rounds in flight; then each thread reads the records of its cell. Units of 16 bytes lie
//   [unit][particle of the round][cell]: no bank conflicts, whatever the particles per cell.
// p2g_direct: no staging, each thread reads its cell's records through L1, the next one in flight.
// Roles: 1: a thread sums all seven quantities; 2: half the warps momentum, half force (fewer registers).

#include "copy_async.cuh"
#include "slice.cuh"

namespace lab {

template <class Real>
struct StagedRecord {
    static constexpr int units = 4 * 4 * int(sizeof(Real)) / 16;
    static constexpr int per_row = units / 4;
    static constexpr int stride = 3 * cells;  ///< units of 16 bytes from one unit of a record to the next
    static constexpr int round_units = units * stride;

    template <bool Stress = true>
    static __device__ __forceinline__ void start(const Columns<Real>& p, std::uint32_t s, uint4* to) {
        const uint4* rows[4] = {
            reinterpret_cast<const uint4*>(p.place + s), reinterpret_cast<const uint4*>(p.motion + s),
            reinterpret_cast<const uint4*>(p.normal + s), reinterpret_cast<const uint4*>(p.shear + s)};
#pragma unroll
        for (int u = 0; u < (Stress ? units : units / 2); ++u)
            copy_async(to + u * stride, rows[u / per_row] + u % per_row);
    }
    template <class T>
    static __device__ __forceinline__ T row(const uint4* from, int r) {
        T t;
#pragma unroll
        for (int u = 0; u < per_row; ++u) reinterpret_cast<uint4*>(&t)[u] = from[(r * per_row + u) * stride];
        return t;
    }
};

template <class Real, int Stages>
constexpr int staged_bytes() {
    const int records = Stages * StagedRecord<Real>::round_units * 16;
    const int planes = all_planes_bytes<Real> + 7 * tile_nodes * int(sizeof(Real));
    return records > planes ? records : planes;
}

template <class Real, bool Momentum, bool Force>
__device__ __forceinline__ void sum_round(const uint4* round, int cell, std::uint32_t left, int k, Real inverse_cell,
                                          SliceSums<Real>& s) {
    using R = StagedRecord<Real>;
#pragma unroll 1
    for (std::uint32_t i = 0; i < left && i < 3; ++i) {
        const uint4* from = round + i * cells + cell;
        const auto x = R::template row<Place<Real>>(from, 0);
        const auto m = R::template row<Row<Real>>(from, 1);
        Row<Real> n, t;
        if constexpr (Force) n = R::template row<Row<Real>>(from, 2), t = R::template row<Row<Real>>(from, 3);
        add_particle<Real, Momentum, Force>(x, m, n, t, k, inverse_cell, s);
    }
}

/// What a thread of a block of the grid works on.
struct Share {
    int cell, k;
    const std::uint32_t* slots;
    std::uint32_t count;
    const std::uint32_t* most;  ///< fullest cell of either half of the block, after a barrier

    __device__ __forceinline__ int rounds() const {
        __syncthreads();
        return (int(max(most[0], most[1])) + 2) / 3;
    }
};

/// Called by whole thread blocks of a multiple of 192 threads.
template <class Real>
__device__ __forceinline__ Share share_of(const View<Real>& v, int b) {
    __shared__ std::uint32_t most[2];
    const int t = int(threadIdx.x) % 192;
    Share s;
    s.cell = t & 63, s.k = t >> 6, s.most = most;
    const std::uint32_t* at = v.cell_first + std::size_t(b) * bounds + s.cell;
    const std::uint32_t first = at[0], begin = v.first[b];
    s.count = at[1] - first;
    s.slots = v.slot + begin + first;
    const std::uint32_t warp_most = __reduce_max_sync(0xffffffffu, s.count);
    if (threadIdx.x < 64 && threadIdx.x % 32 == 0) most[threadIdx.x / 32] = warp_most;
    return s;
}

inline constexpr std::uint32_t none = 0xffffffffu;

/// Adds up this warp's share of the rounds, then its planes. The rounds may lie where the planes will.
template <class Real, int Stages, bool Momentum, bool Force>
__device__ __forceinline__ void run_rounds(const View<Real>& v, const Share& share, bool stages_too, uint4* shared,
                                           Real* planes) {
    using R = StagedRecord<Real>;
    const int k = share.k, cell = share.cell;
    const std::uint32_t* slots = share.slots;
    const std::uint32_t count = share.count;
    SliceSums<Real> sums;
    clear<Real, Momentum, Force>(sums);
    const auto start = [&](int r) {
        const std::uint32_t l = 3 * std::uint32_t(r) + k;
        if (stages_too && l < count)
            R::template start<Force || !Momentum>(v.p, slots[l],
                                                  shared + r % Stages * R::round_units + k * cells + cell);
        commit_async();
    };
    for (int r = 0; r < Stages - 1; ++r) start(r);
    const int rounds = share.rounds();
    for (int r = 0; r < rounds; ++r) {
        wait_async<Stages - 2>();
        __syncthreads();
        start(r + Stages - 1);
        const std::uint32_t done = 3 * std::uint32_t(r);
        if (count > done)
            sum_round<Real, Momentum, Force>(shared + r % Stages * R::round_units, cell, count - done, k,
                                             v.inverse_cell, sums);
    }
    wait_async<0>();
    __syncthreads();
    middle_from_sums<Real, Momentum, Force>(sums);
    add_to_planes<Real, Momentum, Force>(sums, k, cell, planes);
    __syncthreads();
}

template <class Real, int Stages, int Roles, int MinBlocks>
__global__ void __launch_bounds__(192 * Roles, MinBlocks) p2g_staged(const __grid_constant__ View<Real> v) {
    extern __shared__ uint4 shared[];
    const int b = v.chosen();
    const Share s = share_of(v, b);
    if (threadIdx.x == 0 && v.ahead > 0) prefetch_block(v, int(blockIdx.x) + v.ahead);
    if (v.cell_first[std::size_t(b) * bounds + cells] == 0) return;
    Real* planes = reinterpret_cast<Real*>(shared);
    if constexpr (Roles == 1) {
        run_rounds<Real, Stages, true, true>(v, s, true, shared, planes);
    } else {
        if (threadIdx.x < 192)
            run_rounds<Real, Stages, true, false>(v, s, false, shared, planes);
        else
            run_rounds<Real, Stages, false, true>(v, s, true, shared, planes);
    }
    write_tile(v, b, planes, planes + planes_reals<Real>);
}

/// Momentum first, then force: half the sums at a time, so that two thread blocks of doubles fit.
template <class Real, int Stages, int MinBlocks>
__global__ void __launch_bounds__(192, MinBlocks) p2g_passes(const __grid_constant__ View<Real> v) {
    extern __shared__ uint4 shared[];
    const int b = v.chosen();
    const Share s = share_of(v, b);
    if (threadIdx.x == 0 && v.ahead > 0) prefetch_block(v, int(blockIdx.x) + v.ahead);
    if (v.cell_first[std::size_t(b) * bounds + cells] == 0) return;
    Real* planes = reinterpret_cast<Real*>(shared + Stages * StagedRecord<Real>::round_units);
    run_rounds<Real, Stages, true, false>(v, s, true, shared, planes);
    run_rounds<Real, Stages, false, true>(v, s, true, shared, planes);
    write_tile(v, b, planes, reinterpret_cast<Real*>(shared));
}
template <class Real, int Stages>
constexpr int passes_bytes() {
    return Stages * StagedRecord<Real>::round_units * 16 + all_planes_bytes<Real>;
}

template <class Real, int MinBlocks>
__global__ void __launch_bounds__(192, MinBlocks) p2g_direct(const __grid_constant__ View<Real> v) {
    extern __shared__ uint4 shared[];
    const int b = v.chosen();
    const std::uint32_t begin = v.first[b];
    if (v.first[b + 1] == begin) return;
    Real* planes = reinterpret_cast<Real*>(shared);
    const int cell = int(threadIdx.x) & 63, k = int(threadIdx.x) >> 6;
    const std::uint32_t* at = v.cell_first + std::size_t(b) * bounds + cell;
    const std::uint32_t* slots = v.slot + begin + at[0];
    const std::uint32_t count = at[1] - at[0];
    SliceSums<Real> sums;
    clear<Real, true, true>(sums);
    std::uint32_t next = count > 0 ? slots[0] : 0;
#pragma unroll 1
    for (std::uint32_t l = 0; l < count; ++l) {
        const std::uint32_t s = next;
        if (l + 1 < count) next = slots[l + 1];
        add_particle<Real, true, true>(load_row(v.p.place + s), load_row(v.p.motion + s), load_row(v.p.normal + s),
                                       load_row(v.p.shear + s), k, v.inverse_cell, sums);
    }
    middle_from_sums<Real, true, true>(sums);
    add_to_planes<Real, true, true>(sums, k, cell, planes);
    __syncthreads();
    write_tile(v, b, planes, planes + planes_reals<Real>);
}

}  // namespace lab
