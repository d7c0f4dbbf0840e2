#pragma once
// The stress update of one material's particles from dL per list entry: one thread per entry.
//
// Work is summed over the block's own particles of this material in a fixed tree, then rounded once.

#include "gpu/kernels/g2p/g2p_particle.cuh"
#include "gpu/kernels/g2p/stress_particle.cuh"

namespace moraine::gpu {

template <class Real, int Dim, class Law>
struct StressShared {
    RowsAhead<Real, law_rows<Law, Dim>, Dim * Dim, Team<Dim>::threads> rows;
    double sums[Team<Dim>::warps];

    /// Asks for the rows and the gradient of list entry k in slot s.
    __device__ __forceinline__ void start(const View<Real, Dim>& v, const StressArgs<Real, Dim>& g, int half,
                                          std::uint32_t k, std::uint32_t s) {
        constexpr int thread_rows = law_rows<Law, Dim>;
#pragma unroll
        for (int r = 0; r < thread_rows; ++r) rows.start(half, Team<Dim>::rank(), r, law_row<Law>(v.p, r, s));
#pragma unroll
        for (int i = 0; i < Dim * Dim; ++i)
            rows.start_scalar(half, Team<Dim>::rank(), i, g.gradient + std::uint64_t(i) * g.gradient_stride + k);
    }

    __device__ __forceinline__ void update(const View<Real, Dim>& v, const StressArgs<Real, Dim>& g, const Law& law,
                                           Real inverse_density, std::uint32_t s, int half, Seen<Real>& tally,
                                           double& power) const {
        const int rank = Team<Dim>::rank();
        CoreRows<Real, Dim> p;
#pragma unroll
        for (int r = 0; r < core_rows<Dim>; ++r) p.row[r] = rows.take(half, rank, r);
        Row<Real> b[stretch_rows<Dim>];
        if constexpr (Law::uses_left_stretch)
            for (int r = 0; r < stretch_rows<Dim>; ++r) b[r] = rows.take(half, rank, core_rows<Dim> + r);
        Mat<Real, Dim> dL;
#pragma unroll
        for (int i = 0; i < Dim; ++i)
#pragma unroll
            for (int j = 0; j < Dim; ++j) dL(i, j) = rows.scalar[half][Dim * i + j][rank];
        const std::uint32_t faults = update_stress(law, inverse_density, dL, g.dt, v.p, s, p, b, tally, power);
#pragma unroll
        for (int r = Dim == 3 ? 1 : 0; r < core_rows<Dim>; ++r) store_row(v.p.core[r] + s, p.row[r]);
        if (faults) note_fault(account_of(v), faults, v.p.id[s]);
    }
};

template <class Real, int Dim, class Law, int MinBlocks>
__global__ void __launch_bounds__(Team<Dim>::block_threads, MinBlocks)
    update_stresses(const __grid_constant__ View<Real, Dim> v, const Chosen chosen,
                    const __grid_constant__ StressArgs<Real, Dim> g, const __grid_constant__ Law law,
                    const Real inverse_density) {
    using T = Team<Dim>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& shared = reinterpret_cast<StressShared<Real, Dim, Law>*>(memory)[T::index()];
    Seen<Real> tally;
    const std::uint32_t count = *chosen.count;
#pragma unroll 1
    for (std::uint32_t item = T::first(); item < count; item += T::stride()) {
        const Work work = work_on(v.list, chosen, item);
        double power = 0;
        each_entry<Dim>(
            v.list.slot, work,
            [&](int half, std::uint32_t k, std::uint32_t s) {
                const std::uint32_t material =
                    g.material_of ? std::uint32_t(g.material_of[v.p.body[s]]) : std::uint32_t(g.mine);
                if (material == std::uint32_t(g.mine)) shared.start(v, g, half, k, s);  // rows of others stay away
                return material;
            },
            [] {},
            [&](std::uint32_t, std::uint32_t s, int half, std::uint32_t material) {
                if (material == std::uint32_t(g.mine)) shared.update(v, g, law, inverse_density, s, half, tally, power);
            });
        power = T::sum(power, shared.sums);
        if (T::rank() == 0) add_exact(&account_of(v).work, g.quantum.of(power));
        T::sync();  // the sums are read: a warp without particles of this material is soon at the next
    }
    tally.fold_into(account_of(v));
}

/// Thread blocks of a multiprocessor: as many as leave a thread the registers it needs.
template <class Real, class Law>
inline constexpr int stress_blocks = sizeof(Real) == 4 ? device_blocks_of<Law>().split
                                                       : device_blocks_of<Law>().double_split;

}  // namespace moraine::gpu
