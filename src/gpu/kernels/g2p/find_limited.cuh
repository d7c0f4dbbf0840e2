#pragma once
// Which blocks have a particle whose acceleration light nodes limit.
//
// The kernel of nodes has marked the node blocks that have light nodes. Then
//   list_marked   lists the chosen blocks that see a mark or a wall, a thread each
//   find_limited  asks their particles, a team per block, packed: a warp with one to ask would take as long as a full
//                 one
// Nothing is read of other blocks but their marks.

#include "gpu/kernels/g2p/light.cuh"
#include "gpu/kernels/nodes/node_work.hpp"
#include "gpu/kernels/warp.cuh"

namespace moraine::gpu {

inline constexpr int list_marked_threads = 128;

template <class Real, int Dim>
__global__ void list_marked(const __grid_constant__ View<Real, Dim> v, const Chosen chosen, const LightArgs<Real> light,
                            std::int32_t* blocks, std::uint32_t* found) {
    const std::uint32_t count = *chosen.count;
#pragma unroll 1
    for (std::uint32_t item = blockIdx.x * blockDim.x + threadIdx.x; item < count; item += gridDim.x * blockDim.x) {
        const int block = chosen.block[item];
        bool marked = v.table.border[block] != 0;
        for (int corner = 0; corner < Block<Dim>::corners; ++corner) {
            const std::int32_t node_block = v.table.node_block[block * Block<Dim>::corners + corner];
            for (int m = 0; m < light_marks<Dim>; ++m)
                marked = marked || light.marks[node_block * light_marks<Dim> + m] != 0;
        }
        light.limited[block] = 0;
        if (marked) blocks[atomicAdd(found, 1u)] = block;
    }
}

template <class Shape, class Real, int Dim>
struct FindLimitedBlocks {
    using T = Team<Dim>;
    static constexpr unsigned most = 4 * T::threads;  ///< particles asked at once
    struct Shared {
        MassTile<Real, Dim, Shape::width> tile;
        CellMasses<Real, Dim> masses;
        std::uint32_t slot[most];  ///< of particles to ask
        unsigned count;            ///< of them
        unsigned limited;
    };

    static __device__ __forceinline__ Vec<Coordinate<Real>, Dim> place(const View<Real, Dim>& v, std::uint32_t s) {
        CoreRows<Real, Dim> p;
        p.row[p.place] = load_row(v.p.core[p.place] + s);
        return place_of<Real, Dim>(p);
    }

    /// Packs those of the entries from k on whose cell has light nodes, as many as fit. Returns where it stopped.
    static __device__ __forceinline__ std::uint32_t pack(const View<Real, Dim>& v, Real full_mass, std::uint32_t k,
                                                         std::uint32_t end, Shared& shared) {
        for (unsigned taken = 0; k < end && taken < most; k += T::threads, taken += T::threads) {
            const std::uint32_t mine = k + unsigned(T::rank());
            if (mine >= end) continue;
            const std::uint32_t s = v.list.slot[mine];
            if (Real(2) * shared.masses.least[number_of<4, Real, Dim>(place(v, s))] < full_mass)
                shared.slot[atomicAdd(&shared.count, 1u)] = s;
        }
        return k;
    }

    static __device__ __forceinline__ bool is_limited(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g,
                                                      int block, std::uint32_t s, const Shared& shared) {
        CoreRows<Real, Dim> p;
#pragma unroll
        for (int r = 0; r < core_rows<Dim>; ++r) p.row[r] = load_row(v.p.core[r] + s);
        const LightParticle<Real, Dim> of{place_of<Real, Dim>(p), s, p.mass(), p.volume()};
        LightStencil<Real, Dim, Shape::width> n;
        return !share_of<Shape, false, (Shape::width < 4)>(v, g, shared.tile, shared.masses,
                                                           cell_at<Shape>(v, block, of.u), of, n)
                    .whole;
    }

    /// Whether a particle of the block is limited: the same on all threads.
    static __device__ __forceinline__ bool ask(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g, int block,
                                               Shared& shared) {
        if (T::rank() == 0) shared.count = shared.limited = 0;
        load_light_tile<Shape>(v, block, shared.tile);
        weigh_cells<Shape>(v, block, shared.tile, shared.masses);
        const std::uint32_t end = v.list.first[block + 1];
        bool limited = false;
#pragma unroll 1
        for (std::uint32_t k = v.list.first[block]; k < end && !limited;) {
            k = pack(v, g.light.full_mass, k, end, shared);
            T::sync();
            const unsigned count = shared.count;
            for (unsigned i = unsigned(T::rank()); i < count; i += T::threads)
                if (is_limited(v, g, block, shared.slot[i], shared)) shared.limited = 1;
            T::sync();
            limited = shared.limited != 0;
            if (T::rank() == 0) shared.count = 0;
            T::sync();
        }
        return limited;
    }
};

template <class Shape, class Real, int Dim>
__global__ void __launch_bounds__(Team<Dim>::block_threads, sizeof(Real) == 8 ? 3 : 4)
    find_limited(const __grid_constant__ View<Real, Dim> v, const Chosen marked,
                 const __grid_constant__ GatherArgs<Real, Dim> g, std::int32_t* blocks, std::uint32_t* found) {
    using T = Team<Dim>;
    using F = FindLimitedBlocks<Shape, Real, Dim>;
    __shared__ typename F::Shared all[T::per_block];
    auto& shared = all[T::index()];
    const std::uint32_t count = *marked.count;
#pragma unroll 1
    for (std::uint32_t item = T::first(); item < count; item += T::stride()) {
        const int block = marked.block[item];
        if (F::ask(v, g, block, shared) && T::rank() == 0) {
            g.light.limited[block] = 1;
            blocks[atomicAdd(found, 1u)] = block;
        }
        T::sync();
    }
}

}  // namespace moraine::gpu
