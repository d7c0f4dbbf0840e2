#pragma once
// Whole cells and their nodes, by one thread each: gradients and divergences are products over the axes, w = (1/6, 2/3,
// 1/6) and g = (-1/2, 0, 1/2), so that a sum over 3^d goes line by line.

#include "core/data/block.hpp"
#include "core/data/vec.hpp"

namespace moraine::gpu {

inline constexpr int cells_along = 4, nodes_along = 6;

template <class Real>
__device__ __forceinline__ constexpr Real whole_weight(int i) {
    return i == 1 ? Real(2.0 / 3) : Real(1.0 / 6);
}
template <class Real>
__device__ __forceinline__ constexpr Real whole_slope(int i) {
    return Real(0.5) * Real(i - 1);
}
/// Of three numbers along an axis.
template <class Real>
__device__ __forceinline__ Real weighted(Real before, Real at, Real behind) {
    return Real(1.0 / 6) * (before + behind) + Real(2.0 / 3) * at;
}

/// sum_i of g along a, w along the others, times v_a, over the axes a: h^(1 - d) V div v of a whole cell. v: by axis,
/// of its first node.
template <class Real, int Dim>
__device__ __forceinline__ Real divergence_of_whole(const Real* const (&v)[Dim]) {
    constexpr int layers = Dim == 3 ? 3 : 1, side = nodes_along;
    Real sum = Real(0);
#pragma unroll
    for (int k = 0; k < layers; ++k) {
        const Real weight = Dim == 3 ? whole_weight<Real>(k) : Real(1);
        const auto line = [&](int a, int j) {
            const Real* x = v[a] + side * (j + side * k);
            return weighted(x[0], x[1], x[2]);
        };
        Real along_x[3];
#pragma unroll
        for (int j = 0; j < 3; ++j) {
            const Real* x = v[0] + side * (j + side * k);
            along_x[j] = x[2] - x[0];
        }
        sum += Real(0.5) * weight * (weighted(along_x[0], along_x[1], along_x[2]) + (line(1, 2) - line(1, 0)));
        if (Dim == 3 && k != 1)
            sum += whole_slope<Real>(k) * weighted(line(Dim - 1, 0), line(Dim - 1, 1), line(Dim - 1, 2));
    }
    return sum;
}

/// sum_i of g along b, w along the others, times v_a: L h^(1 - d) of a whole cell. v: of its first node.
template <class Real, int Dim>
__device__ __forceinline__ Mat<Real, Dim> gradient_of_whole(const Vec<Real, Dim>* v) {
    Mat<Real, Dim> L = zero_mat<Real, Dim>();
#pragma unroll
    for (int n = 0; n < power<Dim>(3); ++n) {
        const int place[3] = {n % 3, n / 3 % 3, n / 9};
        const Vec<Real, Dim>& of = v[place[0] + nodes_along * (place[1] + nodes_along * place[2])];
#pragma unroll
        for (int b = 0; b < Dim; ++b) {
            Real g = Real(1);
#pragma unroll
            for (int a = 0; a < Dim; ++a) g *= a == b ? whole_slope<Real>(place[a]) : whole_weight<Real>(place[a]);
            if (place[b] == 1) continue;  // no slope there
#pragma unroll
            for (int a = 0; a < Dim; ++a) L(a, b) += g * of[a];
        }
    }
    return L;
}

}  // namespace moraine::gpu
