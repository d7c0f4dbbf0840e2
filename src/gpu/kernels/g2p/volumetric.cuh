#pragma once
// The volumetric means of each cell of a block (core/grid/volumetric.hpp), before the block's particles are gathered:
// two threads per cell gather the divergence alone over the cell's list, one the even entries, one the odd ones.
//
// Gathered twice, but nothing is stored per particle and no kernel is added: the sums of the divergence are a third of
// a gather. The order is the list's, so the bits do not depend on who owns the block.

#include "core/grid/volumetric.hpp"
#include "gpu/kernels/g2p/gather_case.cuh"

namespace moraine::gpu {

template <class Real, int Dim, bool Affine>
__device__ __forceinline__ Real divergence_of(const Gathered<Real, Dim, Affine>& sums) {
    Real sum = sums.gradient[0][0];
#pragma unroll
    for (int a = 1; a < Dim; ++a) sum += sums.gradient[a][a];
    return sum;
}

template <class Real, int Dim>
__device__ __forceinline__ Real stress_trace(const CoreRows<Real, Dim>& p) {
    return p.stress(0) + p.stress(1) + p.stress(2);
}

template <class Real, int Dim>
struct CellMeans {
    Real rate[Block<Dim>::cells];    ///< of the sum of slopes: of tr dL h / dt
    Real stress[Block<Dim>::cells];  ///< of tr sigma [Pa]

    /// Gives the gathered gradients of a particle in the cell its rate.
    template <bool Affine>
    __device__ __forceinline__ void put_rate(int cell, Gathered<Real, Dim, Affine>& sums) const {
        const Real step = trace_step<Dim>(rate[cell], divergence_of(sums));
#pragma unroll
        for (int a = 0; a < Dim; ++a) sums.gradient[a][a] += step;
    }

    /// Gives the normal row of a particle in the cell the mean of its trace.
    __device__ __forceinline__ void put_stress(int cell, CoreRows<Real, Dim>& p) const {
        const Real step = trace_step<3>(stress[cell], stress_trace(p));
#pragma unroll
        for (int a = 0; a < 3; ++a) p.stress(a) += step;
    }
};

/// gathered(s, u): what the particle in slot s at u gathers. Whole teams call it, and see the means afterwards.
template <class Real, int Dim, class F>
__device__ __forceinline__ void average_cells(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g,
                                              const Work& work, CellMeans<Real, Dim>& means, const F& gathered) {
    using T = Team<Dim>;
    static_assert(T::threads == 2 * Block<Dim>::cells);
    const int cell = T::rank() / 2;
    const std::uint32_t* bounds = v.list.cell_first + std::size_t(work.block) * (Block<Dim>::cells + 1) + cell;
    const std::uint32_t end = work.begin + bounds[1];
    VolumetricMean<Real> mean;
#pragma unroll 1
    for (std::uint32_t k = work.begin + bounds[0] + unsigned(T::rank() % 2); k < end; k += 2) {
        const std::uint32_t s = v.list.slot[k];
        if (g.averaged && !g.averaged[v.p.body[s]]) continue;
        CoreRows<Real, Dim> p;
        p.row[p.place] = load_row(v.p.core[p.place] + s);
        p.row[p.normal] = load_row(v.p.core[p.normal] + s);
        mean.add(p.mass(), divergence_of(gathered(s, place_of<Real, Dim>(p))), stress_trace(p));
    }
    mean.rate += __shfl_xor_sync(0xffffffffu, mean.rate, 1);
    mean.stress += __shfl_xor_sync(0xffffffffu, mean.stress, 1);
    mean.mass += __shfl_xor_sync(0xffffffffu, mean.mass, 1);
    mean.finish();
    if (T::rank() % 2 == 0) means.rate[cell] = mean.rate, means.stress[cell] = mean.stress;
    T::sync();
}

template <class Case>
struct MeansTerm {
    static constexpr unsigned hooks = Case::means ? hook_cell | hook_rate | hook_stress : 0u;
    struct Shared : SharedIf<MeansTerm, Case::means, CellMeans<typename Case::Real, Case::dim>> {};

    /// Instances for light nodes and for fluids ask.
    MORAINE_TEAM bool on(const auto& in) { return !(Case::light || Case::fluid) || in.g.averages; }

    MORAINE_TEAM void at_cell(const auto& in, Shared& own, const auto& gathered) {
        if (on(in)) average_cells(in.v, in.g, in.work, own, gathered);
    }
    MORAINE_TEAM void on_rate(const auto& in, const auto& point, const auto& u, auto& sums, const Shared& own, auto&) {
        if (on(in) && point.averaged()) own.put_rate(number_of<4, typename Case::Real, Case::dim>(u), sums);
    }
    MORAINE_TEAM void before_stress(const auto& in, auto& point, auto&, const Shared& own, auto&, double&) {
        if (!on(in) || !point.averaged()) return;
        point.load(point.p.normal);
        own.put_stress(number_of<4, typename Case::Real, Case::dim>(point.place()), point.p);
        point.store(point.p.normal);
    }
};

}  // namespace moraine::gpu
