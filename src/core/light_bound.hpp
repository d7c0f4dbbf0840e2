#pragma once
// A bound that clears a particle of light nodes (light_stencil.hpp) by least masses, for those who must not ask all.
//
//   r_ip <= min(1 / w_ip, M_p / m_i),   M_p <= rho_p h^d
//
// By the least mass of all its nodes:   R_b <= (c dt)^2 M_p / least S_b prod W_a,   a each axis but b,
// with S and W the sums along an axis of dw^2 and w^2: enough inside a body and at its walls. Else by layers of nodes
// across each axis a in turn, one of which is enough at a surface:
//   R_b <= (c dt)^2 sum_k min(w_k T_b, w_k^2 M_p / least_k S_b W_c)
//   R_a <= (c dt)^2 sum_k min(dw_k^2 / w_k, dw_k^2 M_p / least_k W_b W_c)
// with T the sum of dw^2 / w. Ghosts behind walls are no nodes.

#include "core/light_stencil.hpp"

namespace moraine {

/// Least masses of the nodes of a stencil, layer by layer along each axis; ghosts count as heavy [kg].
template <class Real, int Dim, int Width>
struct LayerMasses {
    Real least[Dim][Width];
};

/// Sums of w^2 and dw^2 along each axis of a stencil.
template <class Real, int Dim>
struct SquareSums {
    Vec<Real, Dim> weight, slope;
};

template <class Real, int Dim, int Width>
MORAINE_HD SquareSums<Real, Dim> square_sums(const LightStencil<Real, Dim, Width>& n) {
    SquareSums<Real, Dim> sums;
    for (int a = 0; a < Dim; ++a) {
        sums.weight[a] = sums.slope[a] = Real(0);
        for (int i = 0; i < Width; ++i) {
            sums.weight[a] += n.w[a][i] * n.w[a][i];
            sums.slope[a] += n.dw[a][i] * n.dw[a][i];
        }
    }
    return sums;
}

/// Whether bounds of the reactions are within the limits.
template <class Real, int Dim>
MORAINE_HD bool are_within(const ReactionLimits<Real>& limits, const Vec<Real, Dim>& bound, const bool* folded,
                           Real dilation) {
    Real sum = Real(0);
    bool within = true;
    for (int b = 0; b < Dim; ++b) {
        within = within && !(folded[b] && bound[b] > limits.wall);
        sum += bound[b];
    }
    return within && dilation * sum <= limits.volume;
}

/// By the least mass of all nodes. ratio: (c dt)^2 M_p / least, in the unit of the slopes.
template <class Real, int Dim>
MORAINE_HD bool clears_by_least(const SquareSums<Real, Dim>& sums, Real ratio, const bool* folded, Real dilation,
                                const ReactionLimits<Real>& limits) {
    Vec<Real, Dim> bound;
    for (int b = 0; b < Dim; ++b) {
        bound[b] = ratio * sums.slope[b];
        for (int a = 0; a < Dim; ++a)
            if (a != b) bound[b] *= sums.weight[a];
    }
    return are_within(limits, bound, folded, dilation);
}

/// By the layers across axis a. steep: T of each axis.
template <class Real, int Dim, int Width>
MORAINE_HD bool clears_by_layers(int a, const LightStencil<Real, Dim, Width>& n,
                                 const LayerMasses<Real, Dim, Width>& layers, const SquareSums<Real, Dim>& sums,
                                 const Vec<Real, Dim>& steep, Real full, Real squared, Real dilation,
                                 const ReactionLimits<Real>& limits) {
    Vec<Real, Dim> bound = zero_vec<Real, Dim>();
    for (int k = 0; k < Width; ++k) {
        const Real w = n.w[a][k], slope = n.dw[a][k] * n.dw[a][k];
        if (!(w > Real(0))) continue;
        const Real ratio = layers.least[a][k] > Real(0) ? full / layers.least[a][k] : Real(1e30);
        for (int b = 0; b < Dim; ++b) {
            Real across = ratio;  // the other axes' part of the sum with M_p / m_i
            for (int c = 0; c < Dim; ++c)
                if (c != a) across *= c == b ? sums.slope[c] : sums.weight[c];
            const Real alone = b == a ? slope / w : w * steep[b];
            const Real shared = (b == a ? slope : w * w) * across;
            bound[b] += squared * (alone < shared ? alone : shared);
        }
    }
    return are_within(limits, bound, n.folded, dilation);
}

/// Whether reactions() cannot be more than the limits. squared: (c dt)^2 over the unit of the slopes; full: rho_p h^d.
template <class Real, int Dim, int Width>
MORAINE_HD bool surely_whole(const LightStencil<Real, Dim, Width>& n, const LayerMasses<Real, Dim, Width>& layers,
                             Real full, Real squared, Real dilation, const ReactionLimits<Real>& limits) {
    squared *= Real(1.01);  // what rounding may add
    Real least = layers.least[0][0];
    for (int i = 1; i < Width; ++i) least = layers.least[0][i] < least ? layers.least[0][i] : least;
    const SquareSums<Real, Dim> sums = square_sums(n);
    if (least > Real(0) && clears_by_least(sums, squared * full / least, n.folded, dilation, limits)) return true;
    Vec<Real, Dim> steep = zero_vec<Real, Dim>();
    for (int a = 0; a < Dim; ++a)
        for (int i = 0; i < Width; ++i)
            if (n.w[a][i] > Real(0)) steep[a] += n.dw[a][i] * n.dw[a][i] / n.w[a][i];
    for (int a = 0; a < Dim; ++a)
        if (clears_by_layers(a, n, layers, sums, steep, full, squared, dilation, limits)) return true;
    return false;
}

}  // namespace moraine
