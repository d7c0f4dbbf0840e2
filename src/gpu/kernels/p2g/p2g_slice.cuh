#pragma once
// Sums of one (cell, slice) in registers. With weights w and slopes d per axis, z the slice's:
//
//   mass      m_i += wx wy wz m                                      [kg]
//   momentum  q_i += wx wy wz m (v + h C (x_i - x_p))                [kg m/s]
//   force     f_i -= V/h sigma (dx wy wz, wx dy wz, wx wy dz)        [N]
//   mean      s_i += wx wy wz (m (tr sigma / 3 + rho g.x), or V)     where it is wanted
//
// Components come one after the other, so that little besides the sums is held at a time.

#include "gpu/kernels/p2g/p2g_record.cuh"

namespace moraine::gpu {

template <class Case>
struct SliceSums {
    using Real = typename Case::Real;
    Real mass[Case::nodes], momentum[Case::dim][Case::nodes];
    Real force[Case::dim][Case::nodes];
    Real mean[Case::mean ? Case::nodes : 1];
};

template <class Real, int N>
__device__ __forceinline__ void clear(Real (&sums)[N]) {
#pragma unroll
    for (int n = 0; n < N; ++n) sums[n] = Real(0);
}

/// sums += wx wy value.
template <class Case, class Real>
__device__ __forceinline__ void add_value(const Axis<Case>& x, const Axis<Case>& y, Real value,
                                          Real (&sums)[Case::nodes]) {
#pragma unroll
    for (int j = 0; j < Case::lines; ++j) {
        const Real line = Case::lines == 1 || Case::is_rest(j) ? value : y.w[j] * value;
#pragma unroll
        for (int i = 0; i < Case::width; ++i) {
            Real& sum = sums[i + Case::width * j];
            sum = Case::is_rest(i) ? sum + line : std::fma(x.w[i], line, sum);
        }
    }
}

/// sums += wx wy value + dx wy along_x + wx dy along_y.
template <class Case, class Real>
__device__ __forceinline__ void add_sloped(const Axis<Case>& x, const Axis<Case>& y, Real value, Real along_x,
                                           Real along_y, Real (&sums)[Case::nodes]) {
#pragma unroll
    for (int j = 0; j < Case::lines; ++j) {
        const bool whole = Case::lines == 1 || Case::is_rest(j);
        const Real line = whole ? value : std::fma(y.d[j], along_y, y.w[j] * value);
        const Real slope = whole ? along_x : y.w[j] * along_x;
#pragma unroll
        for (int i = 0; i < Case::width; ++i) {
            Real& sum = sums[i + Case::width * j];
            sum = Case::is_rest(i) ? sum + line : std::fma(x.d[i], slope, std::fma(x.w[i], line, sum));
        }
    }
}

/// Products of the weights of the outer nodes: wx wy at (0, 0), (2, 0), (0, 2), (2, 2). Only where the middle node is
/// what is left: mass and momentum share them.
template <class Case>
struct OuterWeights {
    using Real = typename Case::Real;
    static constexpr bool used = Case::affine && Case::middle_is_rest && Case::lines == 3;
    Real w[used ? 4 : 1];

    __device__ __forceinline__ OuterWeights(const Axis<Case>& x, const Axis<Case>& y) {
        if constexpr (used)
#pragma unroll
            for (int n = 0; n < 4; ++n) w[n] = x.w[n % 2 * 2] * y.w[n / 2 * 2];
    }
};

/// sums += wx wy value, by products of weights.
template <class Case, class Real>
__device__ __forceinline__ void add_value(const Axis<Case>& x, const Axis<Case>& y, const OuterWeights<Case>& outer,
                                          Real value, Real (&sums)[Case::nodes]) {
    if constexpr (!OuterWeights<Case>::used) {
        add_value(x, y, value, sums);
    } else {
#pragma unroll
        for (int n = 0; n < 9; ++n) {
            const int i = n % 3, j = n / 3;
            if (Case::is_rest(i) && Case::is_rest(j))
                sums[n] = sums[n] + value;
            else
                sums[n] = std::fma(Case::is_rest(i)   ? y.w[j]
                                   : Case::is_rest(j) ? x.w[i]
                                                      : outer.w[j + i / 2],
                                   value, sums[n]);
        }
    }
}

/// sums += wx wy (value + x along_x + y along_y), where x, y run from -from_x, -from_y in steps of one. Over a whole
/// line w x adds up to nothing: these shapes reproduce straight lines.
template <class Case, class Real>
__device__ __forceinline__ void add_carried(const Axis<Case>& x, const Axis<Case>& y, const OuterWeights<Case>& outer,
                                            Real from_x, Real from_y, Real value, Real along_x, Real along_y,
                                            Real (&sums)[Case::nodes]) {
    if constexpr (!OuterWeights<Case>::used) {
        const Real low = std::fma(-from_y, along_y, value);
#pragma unroll
        for (int j = 0; j < Case::lines; ++j) {
            const bool whole = Case::lines == 1 || Case::is_rest(j);
            const Real line = whole ? value : y.w[j] * std::fma(Real(j), along_y, low);
            const Real slope = whole ? along_x : y.w[j] * along_x;
            const Real first = std::fma(-from_x, slope, line);
#pragma unroll
            for (int i = 0; i < Case::width; ++i) {
                Real& sum = sums[i + Case::width * j];
                sum = Case::is_rest(i) ? sum + line : std::fma(x.w[i], std::fma(Real(i), slope, first), sum);
            }
        }
    } else {
        const Real at_first = std::fma(-from_x, along_x, value), at_last = std::fma(Real(2), along_x, at_first);
        sums[3] = std::fma(x.w[0], at_first, sums[3]);
        sums[4] = sums[4] + value;
        sums[5] = std::fma(x.w[2], at_last, sums[5]);
#pragma unroll
        for (int j = 0; j < 3; j += 2) {
            const Real up = Real(j) - from_y;
            sums[3 * j] = std::fma(outer.w[j], std::fma(up, along_y, at_first), sums[3 * j]);
            sums[3 * j + 1] = std::fma(y.w[j], std::fma(up, along_y, value), sums[3 * j + 1]);
            sums[3 * j + 2] = std::fma(outer.w[j + 1], std::fma(up, along_y, at_last), sums[3 * j + 2]);
        }
    }
}

/// Adds one particle to a slice. resting: of its cell (Lists).
template <class Case, bool Momentum, bool Force, bool Folded>
__device__ __forceinline__ void add_particle(const Particle<Case>& p, const SliceWeight<Case, Folded>& slice,
                                             unsigned ghosts,
                                             const StencilContext<typename Case::Real, Case::dim>& context,
                                             const typename Case::Scale& scales, const typename Case::Real& resting,
                                             SliceSums<Case>& s) {
    using Real = typename Case::Real;
    constexpr int last = Case::dim - 1;
    const Axis<Case> x = folded_slopes<Case, Folded>(0, ghosts, p.fraction(0), p.half.e[0], p.quarter.e[0]);
    const Axis<Case> y =
        folded_slopes<Case, Folded>(1, ghosts, p.fraction(1), p.half.e[1], p.quarter.e[1]);  // 2-D: not used
    const Real f = p.fraction(last);
    Real w, slope;
    slice.get(ghosts, f, p.half.e[last], p.quarter.e[last], w, slope);
    if constexpr (Momentum) {
        const Real mass = w * p.core.mass(), arm = cell_size(scales) * mass;
        const OuterWeights<Case> outer(x, y);
        add_value(x, y, outer, mass, s.mass);
        const Real reach = Case::Shape::template reach<Real>;
#pragma unroll
        for (int q = 0; q < Case::dim; ++q) {
            if constexpr (Case::affine)
                add_carried(x, y, outer, reach + p.fraction(0), reach + p.fraction(1),
                            std::fma(arm * slice.distance(f), p.C(q, last), mass * p.core.velocity(q)), arm * p.C(q, 0),
                            arm * p.C(q, 1), s.momentum[q]);
            else
                add_value(x, y, mass * p.core.velocity(q), s.momentum[q]);
        }
    }
    if constexpr (Force) {
        const Real scale = -p.core.volume() * context.inverse_cell, across = scale * w, tip = scale * slope;
        Real mean = Real(0), less = Real(0);
        if constexpr (Case::mean) {
            mean = (p.core.stress(0) + p.core.stress(1) + p.core.stress(2)) * Real(1.0 / 3.0);
            if (scales.of_grid) less = mean;
        }
        const auto stress = [&](int a, int b) {
            const Real whole = p.core.stress(Sym<Real, Case::dim>::index(a, b));
            return Case::mean && a == b ? whole - less : whole;
        };
#pragma unroll
        for (int q = 0; q < Case::dim; ++q)
            add_sloped(x, y, tip * stress(q, last), across * stress(q, 0), across * stress(q, 1), s.force[q]);
        if constexpr (Case::mean) {
            Real pressure = mean + resting;
#pragma unroll
            for (int a = 0; a < Case::dim; ++a) pressure += context.gravity_slope[a] * p.fraction(a);
            add_value(x, y, w * (scales.volumes ? p.core.volume() : p.core.mass() * pressure), s.mean);
        }
    }
}

/// Middle nodes = whole lines - outer nodes, in x, then in y.
template <class Case, class Real>
__device__ __forceinline__ void take_outer_from_middle(Real (&sums)[Case::nodes]) {
    static_assert(Case::width == 3);
#pragma unroll
    for (int j = 0; j < Case::lines; ++j) sums[3 * j + 1] = sums[3 * j + 1] - sums[3 * j] - sums[3 * j + 2];
    if constexpr (Case::lines == 3) {
#pragma unroll
        for (int i = 0; i < 3; ++i) sums[3 + i] = sums[3 + i] - sums[i] - sums[6 + i];
    }
}

}  // namespace moraine::gpu
