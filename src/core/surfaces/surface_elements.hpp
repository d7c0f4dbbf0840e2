#pragma once
// Contact of soil with rigid structures, as impulses on the surface in each cell that it cuts (cut_cell.hpp): an
// element.
//
//   w_ie = S_ie . n_e / A_e                         share of node i in element e; their sum is 1
//   u_e = sum_i w_ie (v_i - V)                      W_i = sum_e A_e w_ie (elements that the soil touches)
//   R_e = sum_i w_ie W_i / m_i
//   l_n = max(0, -g_e / dt - u_e . n_e) / R_e       away from the structure                   [kg m/s per area]
//   l_t = |u_e along the surface| / R_e at most, by the law
//   v_i += sum_e A_e w_ie (l_n n_e - l_t t_e) / m_i,  the structure gets the opposite
//
// l_n is Signorini's condition (core/structures/contact.hpp) at the surface: the gap g_e of the soil does not close
// beyond zero in a step, and nothing is drawn back. Held at nodes, a film could not get thinner than up to the last
// node that is held. R_e is the row sum of the elements' answer to each other: a velocity that is the same along the
// surface ends in one sweep, and as all weights are positive none is overshot, so that there is no number to choose, no
// limit of the step, and no energy to gain. Where surfaces meet, W_i is a tensor, sum_e A_e w_ie n n, of which an
// element takes what acts in its own direction: what is across does not brake. A slave's share falls to the two nodes
// that it follows (surface_geometry.hpp), or to the first where the second is not the cell's: the second has a negative
// share, so that W_i and R_e are sums of |w_ie|. By w_ie rows near zero threw light nodes away.
//
// One sweep leaves a part of a motion that differs from element to element, so that a solid that rolls would sink in
// step by step. Where pressures are the particles' a second sweep acts on what is left, in no time: friction sees its
// l_n alone, and no drag acts. There soil that is below the surface comes back, l_n (1 + q), q = -g_e / 0.05 h up to 1.
// As a row sum bounds what elements do together, a share of up to 1 gains no energy; in the first sweep it would return
// what forces gave in this step, and fluids at rest would rise (S24), as some do by a second sweep, which they do not
// need.
//
// The law sees l_n and the pressure of the cell, N_e.

#include "core/structures/contact.hpp"
#include "core/surfaces/surface_node.hpp"

namespace moraine {

inline constexpr double touches_below = 0.5;  ///< gap of soil that a surface acts on [cells]

/// The surface in a cell.
template <int Dim>
struct SurfaceElement {
    static constexpr int nodes = power<Dim>(3);
    int cell;                          ///< of its block
    int structure;                     ///< whose it is
    double area;                       ///< A_e [m^(d-1)]
    Vec<double, Dim> normal, place;    ///< [m]
    double weight[nodes], own[nodes];  ///< w_ie, and before slaves gave theirs away
    double friction, cap;              ///< of the law there
    double gap = 0, covered = 0;       ///< of this step: [cells], and the share of it that soil lies on
    bool touches = false;
};

/// An element as particles of a block look at it.
template <int Dim>
struct RingElement {
    double area = 0;   ///< [cells]; 0: there is none
    double reach = 0;  ///< a quarter past its ends: particles within that from its middle may touch it [cells]
    int structure = -1;
    int node = 0;                    ///< of the block's tile, in the middle of its cell
    Vec<double, Dim> normal, place;  ///< [cells, from the block's first cell]
};

/// A slave, by nodes of a block's tile: it follows `one` and `two`.
struct Slave {
    int own, one, two;
};

/// And what it finds of the surface.
template <int Dim>
struct SlaveNode {
    Slave nodes;
    SurfaceNode<Dim> surface;
    double beside[3];  ///< what other slaves have of `own`, `one` and `two` (SurfaceGeometry)
};

/// Lane of a node's sums that number n of them has: those that travel (node_sums), then the mean's.
template <int Dim>
MORAINE_HD constexpr int sum_lane(int n) {
    return Dim == 2 ? (n < 3 ? n : n < 5 ? n + 1 : 7) : n;
}

/// Symmetric tensors by lanes: xx, yy, xy in 2-D, xx, yy, zz, xy, yz, zx in 3-D.
template <int Dim>
struct SurfaceShares {
    static constexpr int count = Dim * (Dim + 1) / 2;
    double across[count];  ///< sum_e A_e w_ie n n
    double own;            ///< sum_e A_e w_ie, before slaves gave theirs away

    MORAINE_HD double all() const {
        double sum = 0;
        for (int a = 0; a < Dim; ++a) sum += across[a];
        return sum;
    }
    MORAINE_HD double along_normal(const Vec<double, Dim>& n) const {
        double sum = 0;
        for (int a = 0; a < Dim; ++a) {
            sum += across[a] * n[a] * n[a];
            if (Dim == 3 || a == 0) sum += 2 * across[Dim + a] * n[a] * n[(a + 1) % Dim];
        }
        return sum;
    }
};

template <int Dim>
MORAINE_HD double tensor_lane(const Vec<double, Dim>& n, int lane) {
    return lane < Dim ? n[lane] * n[lane] : n[lane - Dim] * n[(lane - Dim + 1) % Dim];
}

/// A slave's share of an element's weights, by the place `o` of the slave in the cell's stencil: falls to its masters.
template <int Dim>
void give_away(const SurfaceNode<Dim>& slave, int o, SurfaceElement<Dim>& e) {
    if (!(slave.slaved > 0) || !(e.own[o] > 0)) return;
    int first = 0, second = 0, stride = 1, rest = o;
    bool has_first = true, has_second = true;
    for (int a = 0; a < Dim; ++a, rest /= 3, stride *= 3) {
        const int one = rest % 3 + slave.to[a], two = one + slave.to[a];
        has_first = has_first && one >= 0 && one < 3;
        has_second = has_second && two >= 0 && two < 3;
        first += stride * one, second += stride * two;
    }
    if (!has_first) return;
    const double given = slave.slaved * e.own[o];
    e.weight[o] -= given;
    e.weight[first] += has_second ? 2 * given : given;
    if (has_second) e.weight[second] -= given;
}

/// The share of the speed that a first sweep has left across the surface with which soil comes back from below it; gap:
/// [cells].
MORAINE_HD double comes_back(double gap) {
    constexpr double whole_from = 0.05;
    return gap < -whole_from ? 1.0 : gap < 0 ? -gap / whole_from : 0.0;
}

/// What presses an element: l_n, and the impulse of the cell's pressure [kg m/s per area].
struct Pressing {
    double contact, pressure;
};

/// The most that the law lets an element take per area, of the slip's own size `speed` / row; leaves: u_e . n_e; dt: in
/// which it acts.
template <int Dim>
MORAINE_HD double most_along(InterfaceLaw law, const SurfaceElement<Dim>& e, const Pressing& by, double leaves,
                             double speed, double row, double dt) {
    const double press = by.contact + by.pressure;
    switch (law) {
        case InterfaceLaw::rough:
            return (by.pressure > 0 && e.gap < touches_below) || (e.gap < touching && (by.contact > 0 || leaves < 0))
                       ? speed / row
                       : 0.0;
        case InterfaceLaw::coulomb:
            return e.friction * press;
        case InterfaceLaw::undrained:
            return e.cap * e.covered * dt;
        case InterfaceLaw::voellmy:
            return (speed - after_drag(speed - e.friction * press * row, e.cap * e.covered * dt * row)) / row;
        default:
            return 0;
    }
}

}  // namespace moraine
