#pragma once
// Kinetic energy that the affine fields of APIC and TPIC hold.
//
// A particle gives node i the momentum w_ip m_p (v_p + C_p (x_i - x_p)). Constants and straight lines are exact,
// sum w_ip (x_i - x_p) = 0, so what it gives all of them has the energy
//   sum_i w_ip m_p |v_p + C_p (x_i - x_p)|^2 / 2 = m_p |v_p|^2 / 2 + m_p sum_ab C_ab^2 D_b / 2,
//   D_b = sum_i w_ip (x_i - x_p)_b^2 along axis b,
// h^2/4 for the quadratic spline and h^2/3 for the cubic. Nodes that several particles share keep this or less
// (Jensen). Of boxes (GIMP) it swings by a factor of two as they pass nodes, with a C that nothing changes; taken here
// is its mean over all places, h^2 (1/6 + l^2/3), l the half-size in cells. Where a ghost node is folded it is that of
// the place, with the folded weights: there it falls to 0 on the wall.

#include "core/grid/shape.hpp"
#include "core/grid/stencil.hpp"
#include "simulation/diagnostics.hpp"

namespace moraine::verification {

/// D_b [m2] of the particle in slot s of own block b.
template <class Shape, class Real, int Dim>
Vec<double, Dim> affine_inertia(const Simulation<Real, Dim>& sim, const SharePiece<Real, Dim>& piece, int b,
                                std::uint32_t s) {
    const StencilContext<Real, Dim>& context = sim.method().context;
    auto n = stencil<Real, Dim, Shape>(context, piece.p, s);
    Vec<double, Dim> inertia = zero_vec<double, Dim>();
    for (int a = 0; a < Dim; ++a) {
        const int base = first_node<Shape>(piece.tables.position[static_cast<std::size_t>(b)][a]) +
                         static_cast<int>(cell_of<Real>(piece.p.position[s][a]));
        const unsigned ghosts = context.walls.ghosts(a, base, Shape::width);
        if (Shape::sized && ghosts == 0) {
            const double half = double(gimp_half(context, piece.p, s, a)), cell = sim.scene().cell;
            inertia[a] = (1.0 / 6 + half * half / 3) * cell * cell;
            continue;
        }
        fold_weights<Shape::width>(ghosts, n.w[a], n.dw[a]);
        for (int i = 0; i < Shape::width; ++i) {
            const double lever = (i - double(n.f[a]) - Shape::template reach<double>)*sim.scene().cell;
            inertia[a] += double(n.w[a][i]) * lever * lever;
        }
    }
    return inertia;
}

template <class Shape, class Real, int Dim>
double affine_energy_with(const Simulation<Real, Dim>& sim) {
    double energy = 0;
    sim.each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
        for (int b = piece.begin; b < piece.end; ++b)
            for (std::uint32_t s : piece.slots(b)) {
                const Vec<double, Dim> inertia = affine_inertia<Shape>(sim, piece, b, s);
                double square = 0;
                for (int i = 0; i < Dim; ++i)
                    for (int j = 0; j < Dim; ++j) {
                        const double rate = double(piece.p.affine[s](i, j));
                        square += rate * rate * inertia[j];
                    }
                energy += 0.5 * double(piece.p.mass[s]) * square;
            }
    });
    return energy;
}

/// Of this rank's particles [J]; 0 with other transfers. Binned state only. Not collective.
template <class Real, int Dim>
double affine_energy(const Simulation<Real, Dim>& sim) {
    if (!is_affine(sim.scene().transfer)) return 0;
    switch (sim.scene().shape) {
        case Shape::linear:
            return affine_energy_with<Linear>(sim);
        case Shape::quadratic:
            return affine_energy_with<Quadratic>(sim);
        case Shape::cubic:
            return affine_energy_with<Cubic>(sim);
        default:
            return affine_energy_with<Gimp>(sim);
    }
}

}  // namespace moraine::verification
