#pragma once
// The kernels of gpu/kernels/sleep/waves.hpp, by the formula of core/particles/stress.hpp: a warp per block, a law
// each.

#include "gpu/kernels/g2p/stress_particle.cuh"
#include "gpu/kernels/sleep/sleep_warp.cuh"

namespace moraine::gpu {

/// c of the particle in a slot.
template <class Law, class Real, int Dim>
__device__ __forceinline__ double wave_of(const Columns<Real, Dim>& columns, const Law& law, Real inverse_density,
                                          std::uint32_t slot) {
    CoreRows<Real, Dim> p;
#pragma unroll
    for (int r = 0; r < core_rows<Dim>; ++r) p.row[r] = load_row(columns.core[r] + slot);
    Row<Real> b[stretch_rows<Dim>];
    if constexpr (Law::uses_left_stretch)
        for (int r = 0; r < stretch_rows<Dim>; ++r) b[r] = load_row(columns.stretch[r] + slot);
    const PointState<Real, Dim> state = state_of<Law>(p, columns, b, slot);
    return static_cast<double>(signal_speed(law, state, zero_vec<Real, Dim>(), std::exp(p.ln_J()), inverse_density));
}

template <class Real, int Dim, class Law>
__global__ void __launch_bounds__(sleep_threads, 4)
    waves_kernel(const __grid_constant__ View<Real, Dim> v, const std::uint8_t* asleep, double* wave,
                 const __grid_constant__ Law law, const Real inverse_density, const std::uint16_t* material_of,
                 int mine) {
    const int b = static_cast<int>(warp_number());
    if (b >= v.table.own || !asleep[b]) return;
    double most = 0;
    each_slot(v.list, b, [&](std::uint32_t slot) {
        if (material_of && material_of[v.p.body[slot]] != mine) return;
        const double c = wave_of(v.p, law, inverse_density, slot);
        if (most < c) most = c;
    });
    most = warp_max(most);
    if (lane_id() == 0) wave[b] = mine == 0 || wave[b] < most ? most : wave[b];
}

}  // namespace moraine::gpu
