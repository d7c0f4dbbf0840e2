#pragma once
// The stress update of one particle in registers, by the formulas of core/particles/stress.hpp.

#include "core/particles/stress.hpp"
#include "gpu/kernels/copy_async.cuh"
#include "gpu/kernels/seen.cuh"

namespace moraine::gpu {

/// Rows that a law reads and writes: the core rows, then b where it uses it.
template <class Law, int Dim>
inline constexpr int law_rows = core_rows<Dim> + (Law::uses_left_stretch ? stretch_rows<Dim> : 0);

template <class Law, class Real, int Dim>
__device__ __forceinline__ const Row<Real>* law_row(const Columns<Real, Dim>& p, int r, std::uint32_t s) {
    return (r < core_rows<Dim> ? p.core[r] : p.stretch[r - core_rows<Dim>]) + s;
}

/// Component k of b: 3-D (xx yy zz -) (xy yz zx -); 2-D (xx yy zz xy).
template <class Real, int Dim>
__device__ __forceinline__ Real& stretch_of(Row<Real> (&b)[stretch_rows<Dim>], int k) {
    return Dim == 3 && k >= 3 ? b[stretch_rows<Dim> - 1].e[k - 3] : b[0].e[k];
}

template <class Law, class Real, int Dim>
__device__ __forceinline__ PointState<Real, Dim> state_of(const CoreRows<Real, Dim>& p, const Columns<Real, Dim>& all,
                                                          Row<Real> (&b)[stretch_rows<Dim>], std::uint32_t s) {
    PointState<Real, Dim> state;
#pragma unroll
    for (int k = 0; k < Sym<Real, Dim>::size; ++k) state.stress[k] = p.stress(k);
    state.ln_J = p.ln_J();
    state.history[0] = p.history();
#pragma unroll
    for (int k = 1; k < Law::history; ++k) state.history[k] = all.history(k)[s];
    if constexpr (Law::uses_left_stretch)
        for (int k = 0; k < Sym<Real, Dim>::size; ++k) state.left_stretch[k] = stretch_of<Real, Dim>(b, k);
    return state;
}

/// Updates p (with its new velocity) and b by dL; stores b and scalars beyond the first. Returns bits of Fault.
template <class Law, class Real, int Dim>
__device__ __forceinline__ std::uint32_t update_stress(const Law& law, Real inverse_density, const Mat<Real, Dim>& dL,
                                                       Real dt, const Columns<Real, Dim>& all, std::uint32_t s,
                                                       CoreRows<Real, Dim>& p, Row<Real> (&b)[stretch_rows<Dim>],
                                                       Seen<Real>& tally, double& work) {
    PointState<Real, Dim> state = state_of<Law>(p, all, b, s);
    Vec<Real, Dim> velocity;
#pragma unroll
    for (int a = 0; a < Dim; ++a) velocity[a] = p.velocity(a);
    const PointStep<Real> step =
        advance_point(law, strain_increment(dL, dt), state, p.mass(), velocity, inverse_density);
#pragma unroll
    for (int k = 0; k < Sym<Real, Dim>::size; ++k) p.stress(k) = state.stress[k];
    p.ln_J() = state.ln_J;
    p.volume() = step.volume;
    if constexpr (Law::history > 0) p.history() = state.history[0];
#pragma unroll
    for (int k = 1; k < Law::history; ++k) all.history(k)[s] = state.history[k];
    if constexpr (Law::uses_left_stretch) {
        for (int k = 0; k < Sym<Real, Dim>::size; ++k) stretch_of<Real, Dim>(b, k) = state.left_stretch[k];
        for (int r = 0; r < stretch_rows<Dim>; ++r) store_row(all.stretch[r] + s, b[r]);
    }
    work += step.work;
    const auto signal = static_cast<Real>(step.signal);  // was a Real
    if (signal > tally.signal) tally.signal = signal;
    return step.faults;
}

}  // namespace moraine::gpu
