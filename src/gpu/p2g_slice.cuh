#pragma once
// Sums of one (cell, slice) in registers. With weights w and slopes or levers d per axis, z the slice's:
//
//   mass      m_i += wx wy wz m                                 [kg]
//   momentum  q_i += wx wy wz m v + h m C (dx wy wz, wx dy wz, wx wy dz), d levers   [kg m/s]
//   force     f_i -= V/h sigma (dx wy wz, wx dy wz, wx wy dz), d slopes              [N]
//
// Momentum with C and force have one form: a value, and a slope along each axis of the slice.

#include "gpu/p2g_record.cuh"

namespace moraine::gpu {

template <class Case>
struct SliceSums {
    typename Case::Real mass[Case::nodes][1];
    typename Case::Real momentum[Case::nodes][Case::dim];
    typename Case::Real force[Case::nodes][Case::dim];
};

template <class Real, int Nodes, int N>
__device__ __forceinline__ void clear(Real (&sums)[Nodes][N]) {
#pragma unroll
    for (int n = 0; n < Nodes; ++n)
#pragma unroll
        for (int q = 0; q < N; ++q) sums[n][q] = Real(0);
}

/// sums += wx wy value.
template <class Case, class Real, int N>
__device__ __forceinline__ void add_value(const Axis<Case>& x, const Axis<Case>& y, const Real (&value)[N],
                                          Real (&sums)[Case::nodes][N]) {
#pragma unroll
    for (int j = 0; j < Case::lines; ++j)
#pragma unroll
        for (int q = 0; q < N; ++q) {
            const Real line = Case::lines == 1 || Case::is_rest(j) ? value[q] : y.w[j] * value[q];
#pragma unroll
            for (int i = 0; i < Case::width; ++i) {
                Real& sum = sums[i + Case::width * j][q];
                sum = Case::is_rest(i) ? sum + line : fma(x.w[i], line, sum);
            }
        }
}

/// sums += wx wy value + dx wy along[0] + wx dy along[1].
template <class Case, class Real, int N>
__device__ __forceinline__ void add_sloped(const Axis<Case>& x, const Axis<Case>& y, const Real (&value)[N],
                                           const Real (&along)[2][N], Real (&sums)[Case::nodes][N]) {
#pragma unroll
    for (int j = 0; j < Case::lines; ++j)
#pragma unroll
        for (int q = 0; q < N; ++q) {
            const bool whole = Case::lines == 1 || Case::is_rest(j);
            const Real line = whole ? value[q] : fma(y.d[j], along[1][q], y.w[j] * value[q]);
            const Real slope = whole ? along[0][q] : y.w[j] * along[0][q];
#pragma unroll
            for (int i = 0; i < Case::width; ++i) {
                Real& sum = sums[i + Case::width * j][q];
                sum = Case::is_rest(i) ? sum + line : fma(x.d[i], slope, fma(x.w[i], line, sum));
            }
        }
}

/// Adds one particle to slice k.
template <class Case, bool Momentum, bool Force>
__device__ __forceinline__ void add_particle(const Particle<Case>& p, int k, typename Case::Real inverse_cell,
                                             typename Case::Real cell, SliceSums<Case>& s) {
    using Real = typename Case::Real;
    constexpr int dim = Case::dim, last = dim - 1;
    Axis<Case> axis[dim];
#pragma unroll
    for (int a = 0; a < dim; ++a) axis[a] = slopes_of<Case>(p.fraction(a), p.half.e[a], p.quarter.e[a]);
    Real w, d, value[dim], along[2][dim];
    if constexpr (Momentum) {
        const Axis<Case> lever = levers_of(axis[last], p.fraction(last));
        pick(lever, k, w, d);
        const Real mass[1] = {w * p.core.mass()};
        const Real arm = cell * mass[0], tip = cell * d * p.core.mass();
        add_value(axis[0], axis[1], mass, s.mass);
#pragma unroll
        for (int q = 0; q < dim; ++q) {
            value[q] = mass[0] * p.core.velocity(q);
            if constexpr (Case::affine) {
                value[q] = fma(tip, p.C(q, last), value[q]);
                along[0][q] = arm * p.C(q, 0), along[1][q] = arm * p.C(q, 1);
            }
        }
        if constexpr (Case::affine)
            add_sloped(levers_of(axis[0], p.fraction(0)), levers_of(axis[1], p.fraction(1)), value, along, s.momentum);
        else
            add_value(axis[0], axis[1], value, s.momentum);
    }
    if constexpr (Force) {
        pick(axis[last], k, w, d);
        const Real scale = -p.core.volume() * inverse_cell, across = scale * w, tip = scale * d;
#pragma unroll
        for (int q = 0; q < dim; ++q) {
            using S = Sym<Real, dim>;
            value[q] = tip * p.core.stress(S::index(q, last));
            along[0][q] = across * p.core.stress(S::index(q, 0));
            along[1][q] = across * p.core.stress(S::index(q, 1));
        }
        add_sloped(axis[0], axis[1], value, along, s.force);
    }
}

/// Middle nodes = whole lines - outer nodes, in x, then in y.
template <class Case, class Real, int N>
__device__ __forceinline__ void take_outer_from_middle(Real (&sums)[Case::nodes][N]) {
#pragma unroll
    for (int step = 1; step <= Case::width; step += Case::width - 1)
#pragma unroll
        for (int line = 0; line < (step == 1 ? Case::lines : Case::width); ++line) {
            if (step != 1 && Case::lines == 1) continue;
            const int at = step == 1 ? Case::width * line + 1 : line + Case::width;
#pragma unroll
            for (int q = 0; q < N; ++q) sums[at][q] = sums[at][q] - sums[at - step][q] - sums[at + step][q];
        }
}

}  // namespace moraine::gpu
