#pragma once
// Light nodes (light_nodes.hpp), one particle: the sums over its stencil, for the loops of host and devices alike.
//
// Ghost nodes behind walls are folded into the weights, so their values are never asked for. A particle is looked at
// where a node of its stencil holds less than half of a full one, or a ghost is folded; of all others the share is
// whole. `full` there is that of the body at the start, so that a bound for all of them is known beforehand.
//
// Slopes are per metre or per cell, as the caller has them; reactions are in their square, times (c dt)^2.

#include "core/grid/light_nodes.hpp"
#include "core/grid/particle_update.hpp"
#include "core/grid/stencil.hpp"
#include "core/grid/walls.hpp"

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

/// Whether nothing holds a node along axis b: what it moves there after walls and structures, v', is more than a
/// rounding of its speed.
template <class Real, int Dim, class Value>
MORAINE_HD bool moves_along(const Value& now, int b) {
    constexpr Real rounding = sizeof(Real) == 8 ? Real(1e-12) : Real(1e-5);
    Real square = Real(0);
    for (int a = 0; a < Dim; ++a) square += now[a] * now[a];
    return now[b] * now[b] > rounding * rounding * square;
}

/// Reactions by axis over (c dt)^2. around: mass of all nodes but ghosts [kg]; full: rho_p h^d; inverse(tile
/// offset, i, j, k): of a node's mass, 0 of a ghost and where there is none [1/kg]; moves(tile offset, axis): whether
/// nothing holds the node along the axis.
template <bool Unrolled = false, class Real, int Dim, int Width, class Inverse, class Moves>
MORAINE_HD Vec<Real, Dim> reactions(const LightStencil<Real, Dim, Width>& n, Real around, Real full,
                                    const Inverse& inverse, const Moves& moves) {
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
        for (int b = 0; b < Dim; ++b)  // the same twice: each spares registers on devices
            if constexpr (Unrolled) {
                if (moves(node, b)) sum[b] += steep[b][at[b]] * share;
            } else {
                sum[b] += steep[b][at[b]] * (moves(node, b) ? share : Real(0));
            }
    });
    return sum;
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
                                                     const ReactionLimits<Real>& limits,
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
    g.seen = taken_from(g.seen, limits, share, false);
    if constexpr (Affine) g.kept = taken_from(g.kept, limits, share, true);
    return g;
}

}  // namespace moraine
