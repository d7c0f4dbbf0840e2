#pragma once
// The pressure of nearly incompressible fluids and undrained clays on the cells of the grid, and substeps of fluids.
//
// Particles map once per step dt; cell pressures P_c (tension positive) and node velocities go S substeps dts = dt / S
// in it, with the particles' places frozen (split-explicit steps: Klemp and Wilhelmson 1978; two time criteria: Zhang,
// Rezavand and Hu 2019). Stresses of the particles act by their deviators alone, and once per step.
//
//   G_ic = (1 - x) sum_{p in c} V_p grad w_ip + x int_c grad w_i dV,  V_c likewise     x = clamp((fill - 0.8) / 0.15)
//   start:   P_c = K_c / K sum V_p P_p / V_c,  dP_c = 0,  dl_c = 0
//   substep: v_i += dts (f_i / m_i + g - sum_c G_ic (P_c + d dP_c) / m_i), structures, walls     d = 0.2 (S - 1)
//            D_c = sum_i G_ic . v_i / V_c - t/2 tr(L_c L_c),  dP_c = K_c dts D_c,  P_c += dP_c,  dl_c += dts D_c
//   end:     P_p += K dl_c,  ln J_p += dl_c;  the deviator follows from grad v at the end
//
// A cell is the box of 1 h of the binning, around one node, and reaches 3^d nodes. fill is the least filling of these
// nodes, v_i / (h^d c_i) (over_filling.hpp): where they are full the sums over particles, whose errors grow with the
// level of the pressure (Steffen et al. 2008), give way to exact integrals, and a cell that happens to hold no particle
// takes part. Gradient and divergence are exact transposes, sum_i G_ic = 0: momentum is exact, and the loop is a leap
// frog. -t tr(L L) is what the frozen places leave out of the rate of ln J, L of the start. Because places go by the
// velocity of the end, and D rises by t tr(L L) on the way there, the sum that keeps a body that turns at its volume is
// -dt^2/2 tr(L L) / S. Half of dt^2/2 is taken, whatever S is: what is too much of it at S > 2 makes up for what
// transfers take of a vortex, and the body shrinks; at S = 1 it swells (S26; docs/adr/0009 has the figures of both).
// The damping of the divergence keeps what the step does not resolve from ringing; it is a bulk viscosity 0.2 K dt.
//
// The modulus of a cell that is not whole is bounded for the substep:  K_c <= 1.8^2 V_c / ((1 + 2 d) s dts^2 sum_i
// |G_ic|^2 / m_i). It is a secant, P_c = K_c / K of the particles' mean, and returns to K as the nodes grow heavy. s is
// by how much the largest eigenvalue of cells that share light nodes exceeds that of one alone: at most 2.7 in 2-D and
// 3.7 in 3-D for blocks, thinned at random to 7 % of their particles (docs/adr/0009).
//
// Where the modulus is bounded the cell is loose: its particles' K dl_c at the end is more than the grid felt, K_c
// dl_c. In compression that keeps their volume. Of what goes beyond P_c = 0 they take K_c / K, because the grid cannot
// bear more of that tension (S24: with all of it particles left through walls; with none of it each swing through zero
// compressed them, and energy grew).
//
// Smoothing (pressure_smoothing.hpp) stays inside a cell: P_p goes to the mean of the cell's particles and their
// hydrostatic slope about it, which no node sees, because P_c is that mean. What differs from cell to cell is what the
// forces on the nodes make of it: at rest the cells hold the weight of the particles that are there, in partial cells
// with errors of rho g h. Means over nodes took that away in every step, the flow answered by moving volume, and so
// energy came from nowhere: pools rose (S24; docs/adr/0009).
//
// Geometry is kept as moments: sum_p V_p s^a with powers up to 2 per axis say all of G_ic for the quadratic spline, s
// in [-1/2, 1/2) from the cell's node. Cells belong to blocks and blocks to tiles, so that the force of the cells goes
// to the nodes by the same sums and messages as that of the particles, in an order that depends on blocks alone.

#include <cmath>
#include <cstdint>

#include "core/data/block.hpp"
#include "core/data/grid_views.hpp"
#include "core/data/quad.hpp"
#include "core/fluid/over_filling.hpp"
#include "core/grid/stencil.hpp"
#include "core/grid/volumetric.hpp"
#include "core/material/strain.hpp"

namespace moraine {

/// One substep of a step.
struct Substep {
    int number;  ///< 0, ..., count - 1
    int count;   ///< S
    double dt;   ///< dts [s]

    bool is_first() const { return number == 0; }
    bool is_last() const { return number + 1 == count; }
    double damping() const { return 0.2 * (count - 1); }  ///< d [-]
};

inline constexpr int most_substeps = 10;

/// What a cell holds between substeps. P: mean stress, tension positive.
template <class Real>
struct CellPressure {
    Real volume;     ///< V_c [m^d]; 0: it takes no part
    Real pressure;   ///< P_c [Pa]
    Real change;     ///< dP_c of the last substep [Pa]
    Real increment;  ///< dl_c so far [-]
    Real bulk;       ///< K_c [Pa]
    Real source;     ///< tr(L L) at the start [1/s2]
    Real head;       ///< means of P_p and of rho g . x_p over its particles, at the start [Pa]
    bool whole;      ///< away from walls and full: its nodes' factors are those of whole_cell()
    bool loose;      ///< K_c < K: particles take less tension from it
    bool soft;       ///< its particles' modulus is at most that in `source`, at the end (surfaces/open_faces.hpp)
};

/// Powers of s of one axis.
inline constexpr int cell_powers = 3;

/// Values and slopes of the 3 weights of an axis as polynomials of s, by node and power; folded at walls.
template <class Real>
struct CellBasis {
    Real value[3][cell_powers];
    Real slope[3][cell_powers];  ///< per cell
};

/// ghosts: Walls::ghosts of the cell's stencil.
template <class Real>
MORAINE_HD CellBasis<Real> cell_basis(unsigned ghosts) {
    CellBasis<Real> b{
        {{Real(0.125), Real(-0.5), Real(0.5)}, {Real(0.75), Real(0), Real(-1)}, {Real(0.125), Real(0.5), Real(0.5)}},
        {{Real(-0.5), Real(1), Real(0)}, {Real(0), Real(-2), Real(0)}, {Real(0.5), Real(1), Real(0)}}};
    for (int p = 0; ghosts != 0 && p < cell_powers; ++p) {
        Real w[3], dw[3];
        for (int i = 0; i < 3; ++i) w[i] = b.value[i][p], dw[i] = b.slope[i][p];
        fold_weights<3>(ghosts, w, dw);
        for (int i = 0; i < 3; ++i) b.value[i][p] = w[i], b.slope[i][p] = dw[i];
    }
    return b;
}

/// Moments of a cell that is full along an axis; at a closed end its part in the domain. node: the cell's; in cells.
template <class Real, int Dim>
MORAINE_HD void full_moments(const NodeCapacity<Real, Dim>& capacity, int a, int node, Real* m) {
    m[0] = Real(1), m[1] = Real(0), m[2] = Real(1.0 / 12);
    for (int s = 0; s < 2; ++s)
        if (node == capacity.plane[a][s] && capacity.on[a][s] < Real(1))
            m[0] = Real(0.5), m[1] = s == 0 ? Real(0.125) : Real(-0.125), m[2] = Real(1.0 / 24);
}

/// sum_p V_p prod_a s_a^(power of a), x fastest [m^d].
template <class Real, int Dim>
struct CellMoments {
    static constexpr int count = power<Dim>(cell_powers);
    Real m[count];

    MORAINE_HD void clear() {
        for (int k = 0; k < count; ++k) m[k] = Real(0);
    }
    /// f: place in the cell, 0 to 1.
    MORAINE_HD void add(Real volume, const Real* f) {
        Real x[Dim][cell_powers];
        for (int a = 0; a < Dim; ++a) {
            const Real s = f[a] - Real(0.5);
            x[a][0] = Real(1), x[a][1] = s, x[a][2] = s * s;
        }
        add_product(volume, x);
    }
    /// volume times a product of numbers of the axes.
    MORAINE_HD void add_product(Real volume, const Real (*x)[cell_powers]) {
        for (int k = 0; k < count; ++k) {
            Real term = volume * x[0][k % 3] * x[1][k / 3 % 3];
            if constexpr (Dim == 3) term *= x[Dim - 1][k / 9];
            m[k] += term;
        }
    }
    MORAINE_HD void scale(Real factor) {
        for (int k = 0; k < count; ++k) m[k] *= factor;
    }
    MORAINE_HD Real volume() const { return m[0]; }
};

/// What a cell's nodes take from it.
template <class Real, int Dim>
struct CellNode {
    Real gradient[Dim];  ///< G_ic [m^(d-1)]
};

/// Sums over powers: the moments with one row of the basis per axis.
template <class Real, int Dim>
MORAINE_HD Real contract_moments(const CellMoments<Real, Dim>& moments, const Real* const* row) {
    Real sum = Real(0);
    constexpr int layers = Dim == 2 ? 1 : 3;
    for (int k = 0; k < layers; ++k) {
        Real plane = Real(0);
        for (int j = 0; j < 3; ++j) {
            const Real* m = moments.m + 3 * (j + 3 * k);
            plane += row[1][j] * (m[0] * row[0][0] + m[1] * row[0][1] + m[2] * row[0][2]);
        }
        if constexpr (Dim == 3) plane *= row[Dim - 1][k];
        sum += plane;
    }
    return sum;
}

template <class Real, int Dim>
MORAINE_HD CellNode<Real, Dim> cell_node(const CellMoments<Real, Dim>& moments, const CellBasis<Real>* basis,
                                         Real inverse_cell, const int* at) {
    CellNode<Real, Dim> node;
    for (int b = 0; b < Dim; ++b) {
        const Real* row[Dim];
        for (int a = 0; a < Dim; ++a) row[a] = a == b ? basis[a].slope[at[a]] : basis[a].value[at[a]];
        node.gradient[b] = contract_moments(moments, row) * inverse_cell;
    }
    return node;
}

/// Of all 3^d nodes, x fastest.
template <class Real, int Dim>
MORAINE_HD void all_cell_nodes(const CellMoments<Real, Dim>& moments, const CellBasis<Real>* basis, Real inverse_cell,
                               CellNode<Real, Dim>* factor) {
    int n = 0;
    each_node<Dim, 3>([&](int, int i, int j, int k) {
        const int at[3] = {i, j, k};
        factor[n++] = cell_node<Real, Dim>(moments, basis, inverse_cell, at);
    });
}

/// Of a cell that is full and away from walls.
template <class Real, int Dim>
MORAINE_HD void whole_cell(Real inverse_cell, CellNode<Real, Dim>* factor) {
    CellMoments<Real, Dim> moments;
    Real x[Dim][cell_powers], volume = Real(1);
    CellBasis<Real> basis[Dim];
    for (int a = 0; a < Dim; ++a) {
        x[a][0] = Real(1), x[a][1] = Real(0), x[a][2] = Real(1.0 / 12);
        basis[a] = cell_basis<Real>(0);
        volume /= inverse_cell;
    }
    moments.clear();
    moments.add_product(volume, x);
    all_cell_nodes(moments, basis, inverse_cell, factor);
}

/// 1 where exact integrals stand for the sums of the particles, 0 where they do not. fill: the least of the nodes.
template <class Real>
MORAINE_HD Real share_of_integral(Real fill) {
    const Real share = (fill - Real(0.8)) / Real(0.15);
    return share < Real(0) ? Real(0) : share > Real(1) ? Real(1) : share;
}

/// The modulus that a substep bears [Pa]. weight: of the cell's row, no less than its largest eigenvalue [m^(2d-2)/kg].
template <class Real>
MORAINE_HD Real bulk_below(Real bulk, Real volume, Real weight, double dt, double damping) {
    const Real most = Real(1.8 * 1.8 / (dt * dt * (1 + 2 * damping))) * volume / weight;
    return bulk < most ? bulk : most;
}

/// The same by sum_i |G_ic|^2 / m_i of a cell alone.
template <int Dim, class Real>
MORAINE_HD Real bounded_bulk(Real bulk, Real volume, Real weight, double dt, double damping) {
    constexpr double shared = Dim == 2 ? 2.75 : 4;
    return bulk_below(bulk, volume, Real(shared) * weight, dt, damping);
}

/// Of a cell's increment of ln J, what goes beyond P_c = 0 in a loose cell; 0 in others.
template <class Real>
MORAINE_HD Real increment_in_tension(const CellPressure<Real>& cell) {
    const Real tension = cell.loose ? cell.pressure / cell.bulk : Real(0);  // as a strain, at the end
    if (!(tension > Real(0))) return Real(0);
    return tension < cell.increment ? tension : cell.increment;
}

/// Of a particle's pressure, the share that its cell bears: K_c / K. loose: K_c where the cell is loose, else 0.
template <class Real>
MORAINE_HD Real borne_share(Real loose, Real bulk) {
    return loose > Real(0) && loose < bulk ? loose / bulk : Real(1);
}

/// What a particle takes of its cell's increment.
template <class Real>
MORAINE_HD Real taken_increment(Real increment, Real in_tension, Real borne) {
    return increment - (Real(1) - borne) * in_tension;
}

/// The strain increment of a step whose volumetric part the cell has: dL with the same H = dL (I + dL/2)^-1 but for its
/// trace. cubic: tr H^3 / 12, what ln J then still gets (strain.hpp).
template <class Real, int Dim>
MORAINE_HD Mat<Real, Dim> increment_of_trace(const Mat<Real, Dim>& dL, Real trace, Real& cubic) {
    Mat<Real, Dim> mid = identity<Real, Dim>();
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) mid(i, j) += Real(0.5) * dL(i, j);
    Mat<Real, Dim> H = dL * inverse(mid);
    set_trace(H, trace);
    cubic = trace_of_cube(H) * Real(1.0 / 12.0);
    mid = identity<Real, Dim>();
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) mid(i, j) -= Real(0.5) * H(i, j);
    return inverse(mid) * H;
}

/// What a cell's step gives its particles.
template <class Real>
struct CellStep {
    Real increment;   ///< of ln J
    Real in_tension;  ///< of it (increment_in_tension())
    Real loose;       ///< K_c of a loose cell, else 0 [Pa]
    Real stiffest;    ///< the most that particles count of their modulus [Pa]

    static MORAINE_HD CellStep of(const CellPressure<Real>& cell) {
        return {cell.increment, increment_in_tension(cell), cell.loose ? cell.bulk : Real(0),
                cell.soft ? cell.source : Real(1e30)};
    }
    /// Of a particle of modulus K = bulk.
    MORAINE_HD Real modulus(Real bulk) const { return stiffest < bulk ? stiffest : bulk; }
};

/// Gives it to a particle of modulus K = bulk, and to its dL. Returns the work [J].
template <class Real, int Dim>
MORAINE_HD double take_cell(const CellStep<Real>& cell, Real bulk, auto& particle, Mat<Real, Dim>& dL) {
    const Real modulus = cell.modulus(bulk);
    const Real increment = taken_increment(cell.increment, cell.in_tension, borne_share(cell.loose, modulus));
    const Real step = modulus * increment;
    const Real before = (particle.stress(0) + particle.stress(1) + particle.stress(2)) * Real(1.0 / 3.0);
    const double work = double(particle.volume()) * double(before + Real(0.5) * step) * double(increment);
    for (int a = 0; a < 3; ++a) particle.stress(a) += step;
    Real cubic;
    dL = increment_of_trace(dL, Real(0), cubic);
    particle.ln_J() += increment - cubic;
    return work;
}

/// |v|^2 of a particle, which the next steps' substeps depend on [m2/s2].
template <class Real, int Dim>
MORAINE_HD Real square_speed(const auto& particle) {
    Real square = Real(0);
    for (int a = 0; a < Dim; ++a) square += particle.velocity(a) * particle.velocity(a);
    return square;
}

}  // namespace moraine
