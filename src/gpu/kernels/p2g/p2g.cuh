#pragma once
// Particle to grid on the device (core/transfer/p2g.hpp says what; benchmarks/device/kernels.md why so): one thread per
// (cell, slice).
//
// Records of particles come round by round into shared memory, `stages` - 1 rounds ahead; a thread sums those of its
// cell in list order in registers. Then cells are combined in planes, and the tile is written. With two passes
// momentum comes first, then force: half the sums to hold, for twice the weights. Every sum has a fixed order whoever
// runs it. What a thread need not hold in registers lies in shared memory (Lists): there are none to spare.

#include "gpu/kernels/p2g/p2g_tile.cuh"

namespace moraine::gpu {

/// A cell's part of its block's list.
struct CellList {
    std::uint32_t begin, count;
};

/// The cells and blocks of a thread block.
template <class Case>
struct Lists {
    CellList cell[Case::cells];
    std::uint32_t most[Case::cells / 32];                       ///< in the fullest cell of each warp
    std::uint32_t group;                                        ///< of `blocks` chosen blocks
    int block[Case::blocks];                                    ///< or -1
    bool border[Case::blocks];                                  ///< ghosts are to be folded
    std::uint16_t ghosts[Case::affine ? Case::cells : 1];       ///< of each cell's stencil, 3 bits per axis
    typename Case::Real resting[Case::mean ? Case::cells : 1];  ///< rho g.x of each cell's stencil [Pa]

    __device__ std::uint32_t fullest() const { return max(most[0], most[1]); }
    __device__ bool any_border() const {
        bool any = false;
        for (int q = 0; q < Case::blocks; ++q) any = any || border[q];
        return any;
    }
};

/// The number of chosen blocks, which no launch changes: asked for anew, so that no register keeps it.
__device__ __forceinline__ std::uint32_t count_now(const Chosen& chosen) {
    std::uint32_t n;
    asm volatile("ld.global.nc.u32 %0, [%1];" : "=r"(n) : "l"(chosen.count));
    return n;
}

/// What a thread finds of its cell: all that is known of the block in one round trip to memory.
template <class Real>
struct Found {
    CellList list{0, 0};
    int block = -1;
    bool border = false;
    unsigned ghosts = 0;
    Real resting = 0;
};

/// This thread's cell among blocks group * blocks, ... of the chosen ones.
template <class Case>
__device__ __forceinline__ Found<typename Case::Real> find_cell(const View<typename Case::Real, Case::dim>& v,
                                                                const Chosen& chosen, std::uint32_t group) {
    constexpr int cells = Block<Case::dim>::cells;
    const unsigned t = thread_now(), c = t % cells;
    const std::uint32_t item = group * Case::blocks + t % Case::cells / cells;
    Found<typename Case::Real> f;
    if (Case::blocks == 1 || item < count_now(chosen)) {
        f.block = chosen.block[item];
        const std::uint32_t* at = v.list.cell_first + std::size_t(f.block) * (cells + 1) + c;
        const std::uint32_t begin = v.list.first[f.block], from = at[0], to = at[1];
        if (Case::width > 2) f.border = v.table.border[f.block] != 0;
        if (Case::affine && f.border) {
#pragma unroll
            for (int a = 0; a < Case::dim; ++a) {
                const int base = first_node<typename Case::Shape>(v.table.position[f.block][a]) +
                                 cell_coordinate<Case::dim>(int(c), a);
                f.ghosts |= v.context.walls.ghosts(a, base, Case::width) << (3 * a);
            }
        }
        if constexpr (Case::mean) {
#pragma unroll
            for (int a = 0; a < Case::dim; ++a) {
                const int base = first_node<typename Case::Shape>(v.table.position[f.block][a]) +
                                 cell_coordinate<Case::dim>(int(c), a);
                f.resting += v.context.gravity_slope[a] * typename Case::Real(base);
            }
        }
        f.list = {begin + from, to - from};
    }
    return f;
}

/// Tells the thread block; complete after a barrier.
template <class Case>
__device__ __forceinline__ void publish(const Found<typename Case::Real>& f, std::uint32_t group, Lists<Case>& lists) {
    const unsigned t = thread_now();
    if (t >= Case::cells) return;
    lists.cell[t] = f.list;
    if constexpr (Case::affine) lists.ghosts[t] = static_cast<std::uint16_t>(f.ghosts);
    if constexpr (Case::mean) lists.resting[t] = f.resting;
    const std::uint32_t most = __reduce_max_sync(0xffffffffu, f.list.count);
    if (t % 32 == 0) lists.most[t / 32] = most, lists.group = group;
    constexpr unsigned cells = Block<Case::dim>::cells;
    if (t % cells == 0) lists.block[t / cells] = f.block, lists.border[t / cells] = f.border;
}

template <class Case, int Stages, bool Momentum, bool Force>
struct Pass {
    using Real = typename Case::Real;
    using R = Record<Case, Momentum, Force>;
    static constexpr int parts = int(Momentum) + int(Force);
    /// The particles of a round one after the other in the code: where there are two passes registers are left for it.
    static constexpr bool unrolled = parts == 1;
    static constexpr int record_bytes = Stages * R::round_units * 16;

    /// Sends for the first rounds of this thread's slice. A round of which it has none is an empty group of copies.
    static __device__ __forceinline__ void start_first(const View<Real, Case::dim>& v, CellList list, uint4* shared) {
        const unsigned t = thread_now();
        std::uint32_t slot[Stages - 1];
#pragma unroll
        for (int r = 0; r < Stages - 1; ++r)
            if (const std::uint32_t l = Case::width * r + t / Case::cells; l < list.count)
                slot[r] = v.list.slot[list.begin + l];
#pragma unroll
        for (int r = 0; r < Stages - 1; ++r) {
            if (Case::width * r + t / Case::cells < list.count) R::start(v, slot[r], shared + r * R::round_units, t);
            commit_async();
        }
    }

    /// Sums all rounds, the first of which were started; ends with a barrier, after which `shared` is free. Away from
    /// walls by a loop of its own: to ask each particle for ghosts takes a quarter of the instructions.
    static __device__ __forceinline__ void sum(const View<Real, Case::dim>& v, const Lists<Case>& lists,
                                               const typename Case::Scale& h, uint4* shared, SliceSums<Case>& sums) {
        each_sum(sums, [](auto& s) { clear(s); });
        if (Case::folds_weights && lists.any_border())
            sum_rounds<Case::folds_weights>(v, lists, h, shared, sums);
        else
            sum_rounds<false>(v, lists, h, shared, sums);
        __syncthreads();
        if constexpr (Case::middle_is_rest) each_sum(sums, [](auto& s) { take_outer_from_middle<Case>(s); });
    }
    static __device__ __forceinline__ void combine(const SliceSums<Case>& sums, Real* planes) {
        const unsigned t = thread_now();
        add_to_planes<Case, Momentum, Force>(sums, int(t / Case::cells), int(t % Case::cells), planes);
    }
    static __device__ __forceinline__ void write(const View<Real, Case::dim>& v, const Lists<Case>& lists,
                                                 Real* planes) {
        write_tiles<Case, Momentum ? 0 : 1, parts>(v, lists.block, !Case::folds_weights && lists.any_border(), planes,
                                                   planes + parts * Planes<Case>::part);
    }

  private:
    template <bool Folded>
    static __device__ __forceinline__ void sum_rounds(const View<Real, Case::dim>& v, const Lists<Case>& lists,
                                                      const typename Case::Scale& h, uint4* shared,
                                                      SliceSums<Case>& sums) {
        const SliceWeight<Case, Folded> slice(int(thread_now() / Case::cells));
#pragma unroll 1
        for (unsigned r = 0; Case::width * r < lists.fullest(); ++r) {
            const unsigned t = thread_now(), k = t / Case::cells, cell = t % Case::cells, stage = r % Stages;
            uint4* round = shared + stage * R::round_units;
            wait_async<Stages - 2>();
            const CellList list = lists.cell[cell];
            if (Case::Shape::sized && Case::width * r + k < list.count) R::finish(v, round + t);
            __syncthreads();
            // What is sent for now comes where the round before this one was.
            if (const std::uint32_t l = Case::width * (r + Stages - 1) + k; l < list.count)
                R::start(v, v.list.slot[list.begin + l],
                         shared + (stage == 0 ? Stages - 1 : stage - 1) * R::round_units, t);
            commit_async();
            const int left = min(int(list.count - Case::width * r), Case::width);
            const auto add = [&](const uint4* record) {
                add_particle<Case, Momentum, Force, Folded>(R::read(round, record), slice,
                                                            Folded ? lists.ghosts[cell] : 0, v.context, h,
                                                            lists.resting[Case::mean ? cell : 0], sums);
            };
            if constexpr (unrolled && !Folded) {
#pragma unroll
                for (int i = 0; i < Case::width; ++i)
                    if (i < left) add(round + int(cell) + i * Case::cells);
            } else {
                const uint4* end = round + int(cell) + left * Case::cells;
#pragma unroll 1
                for (const uint4* record = round + cell; record < end; record += Case::cells) add(record);
            }
        }
    }
    template <class F>
    static __device__ __forceinline__ void each_sum(SliceSums<Case>& sums, const F& f) {
        if (Momentum) f(sums.mass);
#pragma unroll
        for (int q = 0; q < Case::dim; ++q) {
            if (Momentum) f(sums.momentum[q]);
            if (Force) f(sums.force[q]);
        }
        if constexpr (Force && Case::mean) f(sums.mean);
    }
};

constexpr int larger(int a, int b) {
    return a > b ? a : b;
}

/// Dynamic shared memory. One pass: planes of both parts where the records were. Two: records, then planes of one part.
/// Behind the planes: space to fold them in.
template <class Case, int Passes, int Stages>
constexpr int planes_from() {
    return Passes == 1
               ? 0
               : larger(Pass<Case, Stages, true, false>::record_bytes, Pass<Case, Stages, false, true>::record_bytes);
}
template <class Case, int Passes, int Stages>
constexpr int shared_bytes() {
    return Passes == 1
               ? larger(Pass<Case, Stages, true, true>::record_bytes, 2 * Planes<Case>::bytes + fold_bytes<Case, 2>)
               : planes_from<Case, Passes, Stages>() + Planes<Case>::bytes + fold_bytes<Case, 1>;
}

template <class Case, int Passes, int Stages, int Resident>
__global__ void __launch_bounds__(Case::threads, Resident)
    particles_to_grid(const __grid_constant__ View<typename Case::Real, Case::dim> v,
                      const __grid_constant__ Chosen chosen, const typename Case::Scale h) {
    using Real = typename Case::Real;
    extern __shared__ uint4 shared[];
    __shared__ Lists<Case> lists;
    Real* planes = reinterpret_cast<Real*>(shared + planes_from<Case, Passes, Stages>() / 16);
#pragma unroll 1
    for (std::uint32_t group = blockIdx.x; group * Case::blocks < count_now(chosen);) {
        const Found<Real> found = find_cell<Case>(v, chosen, group);
        SliceSums<Case> sums;
        if constexpr (Passes == 1) {
            using All = Pass<Case, Stages, true, true>;
            All::start_first(v, found.list, shared);
            publish(found, group, lists);
            __syncthreads();
            All::sum(v, lists, h, shared, sums);
            All::combine(sums, planes);
            __syncthreads();
            All::write(v, lists, planes);
        } else {
            using First = Pass<Case, Stages, true, false>;
            using Second = Pass<Case, Stages, false, true>;
            First::start_first(v, found.list, shared);
            publish(found, group, lists);
            __syncthreads();
            First::sum(v, lists, h, shared, sums);
            Second::start_first(v, lists.cell[thread_now() % Case::cells], shared);
            First::combine(sums, planes);
            __syncthreads();
            First::write(v, lists, planes);
            Second::sum(v, lists, h, shared, sums);
            Second::combine(sums, planes);
            __syncthreads();
            Second::write(v, lists, planes);
        }
        group = lists.group + gridDim.x;
        __syncthreads();
    }
}

}  // namespace moraine::gpu
