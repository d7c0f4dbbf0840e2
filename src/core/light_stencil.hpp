#pragma once
// Light nodes (light_nodes.hpp), one particle: the sums over its stencil, for the loops of host and devices alike.
//
// Ghost nodes behind walls are folded into the weights, so their values are never asked for. A particle is looked at
// where a node of its stencil holds less than half of a full one, or a ghost is folded; of all others the share is
// whole. `full` there is that of the body at the start, so that a bound for all of them is known beforehand.
//
// Slopes are per metre or per cell, as the caller has them; reactions are in their square, times (c dt)^2.

#include "core/light_nodes.hpp"
#include "core/particle_update.hpp"
#include "core/stencil.hpp"
#include "core/walls.hpp"

namespace moraine {

/// One particle's weights, slopes and levers, folded.
template <class Real, int Dim, int Width>
struct LightStencil {
    Real w[Dim][Width];
    Real dw[Dim][Width];
    Real lever[Dim][Width];  ///< of C; not set where there is none
    bool folded[Dim];        ///< by axis: a ghost was folded into it
};

/// ghosts: by axis, as Walls::ghosts has them. f: place in the binning cell.
template <class Shape, bool Affine, class Real, int Dim>
MORAINE_HD void fold_stencil(const unsigned (&ghosts)[Dim], bool tpic, const Real (&f)[Dim], Real inverse_cell,
                             LightStencil<Real, Dim, Shape::width>& n) {
    for (int a = 0; a < Dim; ++a) {
        n.folded[a] = ghosts[a] != 0;
        fold_weights<Shape::width>(ghosts[a], n.w[a], n.dw[a]);
        if constexpr (Affine) {
            const bool plain = affine_is_gradient<Shape>(tpic, [&] { return n.folded[a]; });
            affine_levers<Shape>(f[a], n.w[a], n.dw[a], inverse_cell, plain, n.lever[a]);
        }
    }
}

/// Whether the node at i, j, k of a stencil is none of its ghosts.
template <int Dim>
MORAINE_HD bool is_inside(const unsigned (&ghosts)[Dim], int i, int j, int k) {
    const int place[3] = {i, j, k};
    bool inside = true;
    for (int a = 0; a < Dim; ++a)
        inside = inside && !((ghosts[a] & 1) && place[a] == 0) && !(place[a] && int(ghosts[a] >> 1) == place[a]);
    return inside;
}

/// Reactions by axis over (c dt)^2. around: mass of all nodes but ghosts [kg]; full: rho_p h^d; inverse(tile
/// offset, i, j, k): of a node's mass, 0 of a ghost and where there is none [1/kg].
template <bool Unrolled = false, class Real, int Dim, int Width, class Inverse>
MORAINE_HD Vec<Real, Dim> reactions(const LightStencil<Real, Dim, Width>& n, Real around, Real full,
                                    const Inverse& inverse) {
    Real steep[Dim][Width];
    for (int a = 0; a < Dim; ++a)
        for (int i = 0; i < Width; ++i) steep[a][i] = steepness(n.w[a][i], n.dw[a][i]);
    const Real most = around < full ? around : full;
    Vec<Real, Dim> sum = zero_vec<Real, Dim>();
    each_node<Dim, Width, Unrolled>([&](int node, int i, int j, int k) {
        const int at[3] = {i, j, k};
        Real w = Real(1);
        for (int a = 0; a < Dim; ++a) w *= n.w[a][at[a]];
        const Real share = reacting_weight(w, most * inverse(node, i, j, k));
        for (int b = 0; b < Dim; ++b) sum[b] += steep[b][at[b]] * share;
    });
    return sum;
}

/// Least masses of the nodes of a stencil, layer by layer along each axis; ghosts count as heavy [kg].
template <class Real, int Dim, int Width>
struct LayerMasses {
    Real least[Dim][Width];
};

/// Sums over one axis of a stencil: of w^2, of dw^2, and of dw^2 / w.
template <class Real>
struct AxisSums {
    Real square, slope, steep;
};

/// Whether reactions() cannot be more than the limits, by layers of nodes across each axis in turn: in layer k
///   r_ip <= min(1 / w_ip, M_p / least_k),   so   R_b <= (c dt)^2 sum_k min(w_k T_b, w_k^2 M_p / least_k S_b W_c)
/// with S, T, W the sums over the other axes of dw^2, dw^2 / w and w^2, and dw_k for w_k where b is the axis of the
/// layers. One axis that says so is enough. squared: (c dt)^2 over the unit of the slopes; full: rho_p h^d.
template <class Real, int Dim, int Width>
MORAINE_HD bool surely_whole(const LightStencil<Real, Dim, Width>& n, const LayerMasses<Real, Dim, Width>& layers,
                             Real full, Real squared, Real dilation, const ReactionLimits<Real>& limits) {
    AxisSums<Real> sums[Dim];
    for (int a = 0; a < Dim; ++a) {
        sums[a] = {Real(0), Real(0), Real(0)};
        for (int i = 0; i < Width; ++i) {
            const Real slope = n.dw[a][i] * n.dw[a][i];
            sums[a].square += n.w[a][i] * n.w[a][i];
            sums[a].slope += slope;
            if (n.w[a][i] > Real(0)) sums[a].steep += slope / n.w[a][i];
        }
    }
    for (int a = 0; a < Dim; ++a) {
        Real bound[Dim];
        for (int b = 0; b < Dim; ++b) bound[b] = Real(0);
        for (int k = 0; k < Width; ++k) {
            const Real w = n.w[a][k], slope = n.dw[a][k] * n.dw[a][k];
            if (!(w > Real(0))) continue;
            const Real ratio = layers.least[a][k] > Real(0) ? full / layers.least[a][k] : Real(1e30);
            for (int b = 0; b < Dim; ++b) {
                Real across = ratio;  // the other axes' part of the sum with M_p / m_i
                for (int c = 0; c < Dim; ++c)
                    if (c != a) across *= c == b ? sums[c].slope : sums[c].square;
                const Real alone = b == a ? slope / w : w * sums[b].steep;
                const Real shared = (b == a ? slope : w * w) * across;
                bound[b] += alone < shared ? alone : shared;
            }
        }
        Real sum = Real(0);
        bool within = true;
        for (int b = 0; b < Dim; ++b) {
            const Real most = Real(1.01) * squared * bound[b];  // 1 %: what rounding may add
            within = within && !(n.folded[b] && most > limits.wall);
            sum += most;
        }
        if (within && dilation * sum <= limits.volume) return true;
    }
    return false;
}

/// Products of weights with `slope` in place of the weight along each axis in turn.
template <class Real, int Dim, int Width>
MORAINE_HD Vec<Real, Dim> slopes_at(const LightStencil<Real, Dim, Width>& n, const Real (&slope)[Dim][Width], int i,
                                    int j, int k) {
    const int at[3] = {i, j, k};
    Vec<Real, Dim> all;
    for (int b = 0; b < Dim; ++b) {
        all[b] = Real(1);
        for (int a = 0; a < Dim; ++a) all[b] *= a == b ? slope[a][at[a]] : n.w[a][at[a]];
    }
    return all;
}

/// Change of a node's velocity, less what a wall would have taken from the velocity before [m/s]. index: of the node;
/// now: v'; change: v' - v.
template <class Real, int Dim, class Value>
MORAINE_HD Vec<Real, Dim> acceleration(const Walls<Real, Dim>& walls, const int* index, const Value& now,
                                       const Value& change) {
    Vec<Real, Dim> before, rest;
    for (int a = 0; a < Dim; ++a) before[a] = now[a] - change[a];
    walls.constrain(index, before);
    for (int a = 0; a < Dim; ++a) rest[a] = now[a] - before[a];
    return rest;
}

/// What is taken from a particle's gradients.
template <class Real, int Dim>
struct TakenGradients {
    Mat<Real, Dim> seen;  ///< from the velocity gradient, in the unit of the slopes
    Mat<Real, Dim> kept;  ///< from C; zero where there is none
};

/// change(tile offset, i, j, k): acceleration() of a node.
template <bool Affine, class Real, int Dim, int Width, class Change>
MORAINE_HD TakenGradients<Real, Dim> taken_gradients(const LightStencil<Real, Dim, Width>& n,
                                                     const LightShare<Real, Dim>& share, const Change& change) {
    TakenGradients<Real, Dim> g;
    for (int a = 0; a < Dim; ++a)
        for (int b = 0; b < Dim; ++b) g.seen(a, b) = g.kept(a, b) = Real(0);
    each_node<Dim, Width>([&](int at, int i, int j, int k) {
        const Vec<Real, Dim> dv = change(at, i, j, k);
        const Vec<Real, Dim> slope = slopes_at(n, n.dw, i, j, k);
        for (int a = 0; a < Dim; ++a)
            for (int b = 0; b < Dim; ++b) g.seen(a, b) += slope[b] * dv[a];
        if constexpr (Affine) {
            const Vec<Real, Dim> arm = slopes_at(n, n.lever, i, j, k);
            for (int a = 0; a < Dim; ++a)
                for (int b = 0; b < Dim; ++b) g.kept(a, b) += arm[b] * dv[a];
        }
    });
    g.seen = taken_from(g.seen, share.axis, share.volume);
    if constexpr (Affine) g.kept = taken_from(g.kept, share.axis_kept, share.volume_kept);
    return g;
}

}  // namespace moraine
