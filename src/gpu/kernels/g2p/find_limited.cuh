#pragma once
// Which blocks have a particle whose acceleration light nodes limit.
//
// The kernel of nodes has marked the node blocks that have light nodes: a team looks at the marks of 8 blocks at once,
// then asks the particles of those that are marked, cell by cell. Nothing is read of other blocks but their marks.

#include "gpu/kernels/g2p/light.cuh"
#include "gpu/kernels/launch.cuh"
#include "gpu/kernels/nodes/nodes.hpp"

namespace moraine::gpu {

template <class Shape, class Real, int Dim>
struct FindLimitedBlocks {
    using T = Team<Dim>;
    static constexpr int at_once = 8;  ///< blocks
    static_assert(at_once * Block<Dim>::corners <= T::threads);
    struct Shared {
        unsigned marked;   ///< bit per block at once
        unsigned limited;  ///< likewise
        // of the block in work
        MassTile<Real, Dim, Shape::width> tile;
        std::uint8_t light[Block<Dim>::cells];
    };

    /// Sets the bits of the blocks item, ..., item + 7 that have light nodes or walls.
    static __device__ __forceinline__ void read_marks(const View<Real, Dim>& v, const Chosen& chosen,
                                                      std::uint32_t count, const LightArgs<Real>& light,
                                                      std::uint32_t item, Shared& shared) {
        constexpr int corners = Block<Dim>::corners;
        if (T::rank() == 0) shared.marked = shared.limited = 0;
        T::sync();
        const std::uint32_t mine = item + unsigned(T::rank() / corners);
        if (T::rank() < at_once * corners && mine < count) {
            const int block = chosen.block[mine], corner = T::rank() % corners;
            const std::int32_t node_block = v.table.node_block[block * corners + corner];
            bool marked = corner == 0 && v.table.border[block] != 0;
            for (int m = 0; m < light_marks<Dim>; ++m)
                marked = marked || light.marks[node_block * light_marks<Dim> + m] != 0;
            if (marked) atomicOr(&shared.marked, 1u << (T::rank() / corners));
        }
        T::sync();
    }

    /// Whether a particle of the team's block is limited, on every thread's own account.
    static __device__ __forceinline__ bool ask_particles(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g,
                                                         int block, Shared& shared) {
        load_light_tile<Shape>(v, block, shared.tile);
        for (int c = T::rank(); c < Block<Dim>::cells; c += T::threads) {
            int at[Dim];
            for (int a = 0; a < Dim; ++a) at[a] = cell_coordinate<Dim>(c, a);
            shared.light[c] = LightCell<Shape, Dim>(v, block, at).is_light(shared.tile, g.light.full_mass);
        }
        T::sync();
        const std::uint32_t end = v.list.first[block + 1];
        bool limited = false;
        for (std::uint32_t k = v.list.first[block] + unsigned(T::rank()); k < end && !limited; k += T::threads) {
            const std::uint32_t s = v.list.slot[k];
            CoreRows<Real, Dim> p;
            p.row[p.place] = load_row(v.p.core[p.place] + s);
            LightParticle<Real, Dim> of{place_of<Real, Dim>(p), s, Real(0), Real(0)};
            if (!shared.light[number_of<4, Real, Dim>(of.u)]) continue;
#pragma unroll
            for (int r = 0; r < core_rows<Dim>; ++r) p.row[r] = load_row(v.p.core[r] + s);
            of.mass = p.mass(), of.volume = p.volume();
            LightStencil<Real, Dim, Shape::width> n;
            limited =
                !share_of<Shape, false, (Shape::width < 4)>(v, g, shared.tile, cell_at<Shape>(v, block, of.u), of, n)
                     .whole;
        }
        return limited;
    }
};

template <class Shape, class Real, int Dim>
__global__ void __launch_bounds__(Team<Dim>::block_threads, 4)
    find_limited(const __grid_constant__ View<Real, Dim> v, const Chosen chosen,
                 const __grid_constant__ GatherArgs<Real, Dim> g, std::int32_t* blocks, std::uint32_t* found) {
    using T = Team<Dim>;
    using F = FindLimitedBlocks<Shape, Real, Dim>;
    __shared__ typename F::Shared all[T::per_block];
    auto& shared = all[T::index()];
    const std::uint32_t count = *chosen.count;
#pragma unroll 1
    for (std::uint32_t item = F::at_once * T::first(); item < count; item += F::at_once * T::stride()) {
        F::read_marks(v, chosen, count, g.light, item, shared);
        const unsigned marked = shared.marked;
#pragma unroll 1
        for (unsigned rest = marked; rest != 0; rest &= rest - 1) {
            const int bit = __ffs(int(rest)) - 1;
            if (F::ask_particles(v, g, chosen.block[item + unsigned(bit)], shared))
                atomicOr(&shared.limited, 1u << bit);
            T::sync();
        }
        if (T::rank() < F::at_once && item + unsigned(T::rank()) < count) {
            const int block = chosen.block[item + unsigned(T::rank())];
            const bool limited = (shared.limited >> T::rank()) & 1;
            g.light.limited[block] = limited;
            if (limited) blocks[atomicAdd(found, 1u)] = block;
        }
        T::sync();
    }
}

template <class Shape, class Real, int Dim>
void run_find_limited(const View<Real, Dim>& view, const Chosen& chosen, const GatherArgs<Real, Dim>& args,
                      std::int32_t* blocks, std::uint32_t* count, const Launch& launch) {
    constexpr int at_once = FindLimitedBlocks<Shape, Real, Dim>::at_once * Team<Dim>::per_block;
    const auto grid = static_cast<unsigned>(few_blocks(launch.blocks / at_once + 1));
    find_limited<Shape, Real, Dim>
        <<<grid, Team<Dim>::block_threads, 0, launch.stream>>>(view, chosen, args, blocks, count);
    check(cudaGetLastError(), "Looking for light nodes");
}

template <class Real, int Dim>
FindLimited<Real, Dim> choose_find_limited(moraine::Shape shape) {
    switch (shape) {
        case moraine::Shape::linear:
            return nullptr;  // never limited (core/method.hpp)
        case moraine::Shape::quadratic:
            return run_find_limited<Quadratic, Real, Dim>;
        case moraine::Shape::cubic:
            return run_find_limited<Cubic, Real, Dim>;
        default:
            return run_find_limited<Gimp, Real, Dim>;
    }
}

}  // namespace moraine::gpu
