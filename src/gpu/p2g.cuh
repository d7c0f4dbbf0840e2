#pragma once
// Particle to grid on the device (core/p2g.hpp says what; benchmarks/gpu_lab why so): one thread per (cell, slice).
//
// Records of particles come round by round into shared memory, `stages` - 1 rounds ahead; a thread sums those of its
// cell in list order in registers. Then cells are combined in planes, and the tile is written. With two passes
// momentum comes first, then force: half the sums to hold, for twice the weights. Every sum has a fixed order whoever
// runs it. What a thread need not hold in registers lies in shared memory (Lists): there are none to spare.

#include "gpu/p2g_tile.cuh"

namespace moraine::gpu {

/// The cells of a thread block.
template <class Case>
struct Lists {
    std::uint32_t begin[Case::cells], count[Case::cells];
    std::uint32_t most[Case::cells / 32];  ///< fullest cell of each warp
    int block[Case::blocks];               ///< or -1
    bool border[Case::blocks];

    __device__ int rounds() const { return (int(max(most[0], most[1])) + Case::width - 1) / Case::width; }
    __device__ bool any_border() const {
        bool any = false;
        for (int q = 0; q < Case::blocks; ++q) any = any || border[q];
        return any;
    }
};

/// Notes the cells of blocks group * blocks, ... of the chosen ones; ends with a barrier. Are there any?
template <class Case>
__device__ __forceinline__ bool find_lists(const View<typename Case::Real, Case::dim>& v, const Chosen& chosen,
                                           std::uint32_t group, Lists<Case>& lists) {
    constexpr int cells = Block<Case::dim>::cells;
    const std::uint32_t count = *static_cast<const volatile std::uint32_t*>(chosen.count);
    if (group * Case::blocks >= count) return false;
    const int t = thread_now();
    if (t < Case::cells) {
        const int q = t / cells, c = t % cells;
        const std::uint32_t item = group * Case::blocks + std::uint32_t(q);
        const int b = item < count ? chosen.block[item] : -1;
        std::uint32_t begin = 0, n = 0;
        if (b >= 0) {
            const std::uint32_t* at = v.list.cell_first + std::size_t(b) * (cells + 1) + c;
            begin = v.list.first[b] + at[0], n = at[1] - at[0];
        }
        lists.begin[t] = begin, lists.count[t] = n;
        const std::uint32_t most = __reduce_max_sync(0xffffffffu, n);
        if (t % 32 == 0) lists.most[t / 32] = most;
        if (c == 0) lists.block[q] = b, lists.border[q] = b >= 0 && Case::width > 2 && v.table.border[b] != 0;
    }
    __syncthreads();
    return true;
}

template <class Case, int Stages, bool Momentum, bool Force>
struct Pass {
    using Real = typename Case::Real;
    using R = Record<Case, Momentum, Force>;
    static constexpr int record_bytes = Stages * R::round_units * 16;

    /// Sends for round r of this thread's slice; an empty group where there is none.
    static __device__ __forceinline__ void start(const View<Real, Case::dim>& v, const Lists<Case>& lists, int r,
                                                 uint4* shared) {
        const int t = thread_now(), cell = t % Case::cells;
        const std::uint32_t l = std::uint32_t(Case::width * r + t / Case::cells);
        if (l < lists.count[cell])
            R::start(v, v.list.slot[lists.begin[cell] + l], shared + r % Stages * R::round_units + t);
        commit_async();
    }
    static __device__ __forceinline__ void start_first(const View<Real, Case::dim>& v, const Lists<Case>& lists,
                                                       uint4* shared) {
#pragma unroll
        for (int r = 0; r < Stages - 1; ++r) start(v, lists, r, shared);
    }

    /// Sums all rounds, the first of which were started; ends with a barrier, after which `shared` is free.
    static __device__ __forceinline__ void sum(const View<Real, Case::dim>& v, const Lists<Case>& lists, Real h,
                                               uint4* shared, SliceSums<Case>& sums) {
        const int t = thread_now(), cell = t % Case::cells, k = t / Case::cells;
        if (Momentum) clear(sums.mass), clear(sums.momentum);
        if (Force) clear(sums.force);
        const int rounds = lists.rounds();
#pragma unroll 1
        for (int r = 0; r < rounds; ++r) {
            uint4* round = shared + r % Stages * R::round_units;
            wait_async<Stages - 2>();
            if (Case::Shape::sized && std::uint32_t(Case::width * r + k) < lists.count[cell]) R::finish(v, round + t);
            __syncthreads();
            start(v, lists, r + Stages - 1, shared);
            const int left = min(int(lists.count[cell]) - Case::width * r, Case::width);
            const uint4* end = round + cell + left * Case::cells;
#pragma unroll 1
            for (const uint4* at = round + cell; at < end; at += Case::cells)
                add_particle<Case, Momentum, Force>(R::read(at), k, v.context.inverse_cell, h, sums);
        }
        __syncthreads();
        if constexpr (Case::middle_is_rest) {
            if (Momentum) take_outer_from_middle<Case>(sums.mass), take_outer_from_middle<Case>(sums.momentum);
            if (Force) take_outer_from_middle<Case>(sums.force);
        }
    }
    static __device__ __forceinline__ void combine(const SliceSums<Case>& sums, Real* planes) {
        const int t = thread_now();
        add_to_planes<Case, Momentum, Force>(sums, t / Case::cells, t % Case::cells, planes);
    }
};

constexpr int larger(int a, int b) {
    return a > b ? a : b;
}

/// Dynamic shared memory. One pass: planes and spare where the records were. Two: records or spare, then planes.
template <class Case, int Passes, int Stages>
constexpr int planes_from() {
    return Passes == 1 ? 0
                       : larger(larger(Pass<Case, Stages, true, false>::record_bytes,
                                       Pass<Case, Stages, false, true>::record_bytes),
                                (fold_bytes<Case> + 15) / 16 * 16);
}
template <class Case, int Passes, int Stages>
constexpr int shared_bytes() {
    constexpr int planes = planes_from<Case, Passes, Stages>() + Planes<Case>::bytes;
    return Passes == 1 ? larger(Pass<Case, Stages, true, true>::record_bytes, planes + fold_bytes<Case>) : planes;
}

template <class Case, int Passes, int Stages, int Resident>
__global__ void __launch_bounds__(Case::threads, Resident)
    particles_to_grid(const __grid_constant__ View<typename Case::Real, Case::dim> v,
                      const __grid_constant__ Chosen chosen, const typename Case::Real h) {
    using Real = typename Case::Real;
    extern __shared__ uint4 shared[];
    __shared__ Lists<Case> lists;
    Real* planes = reinterpret_cast<Real*>(shared + planes_from<Case, Passes, Stages>() / 16);
    Real* spare = Passes == 1 ? planes + Planes<Case>::bytes / int(sizeof(Real)) : reinterpret_cast<Real*>(shared);
#pragma unroll 1
    for (std::uint32_t group = blockIdx.x; find_lists(v, chosen, group, lists); group += gridDim.x) {
        SliceSums<Case> sums;
        if constexpr (Passes == 1) {
            using All = Pass<Case, Stages, true, true>;
            All::start_first(v, lists, shared);
            All::sum(v, lists, h, shared, sums);
            All::combine(sums, planes);
        } else {
            using First = Pass<Case, Stages, true, false>;
            using Second = Pass<Case, Stages, false, true>;
            First::start_first(v, lists, shared);
            First::sum(v, lists, h, shared, sums);
            Second::start_first(v, lists, shared);
            First::combine(sums, planes);
            Second::sum(v, lists, h, shared, sums);
            Second::combine(sums, planes);
        }
        __syncthreads();
        write_tiles<Case>(v, lists.block, lists.any_border(), planes, spare);
        __syncthreads();
    }
}

}  // namespace moraine::gpu
