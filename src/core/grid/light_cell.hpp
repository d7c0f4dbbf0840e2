#pragma once
// What a cell's particles share where nodes may be light (light_nodes.hpp), on the host: what is asked of a node is
// asked once per cell, and reactions() of light_stencil.hpp takes a node's axes as lanes of a quad. Each sum is made of
// the same terms in the same order as there: to the bit.

#include "core/data/quad.hpp"
#include "core/grid/light_stencil.hpp"

namespace moraine {

template <class Real, int Dim, int Width>
struct LightCell {
    static constexpr int layers = Dim == 2 ? 1 : Width;
    using Lanes = typename Quad<Real>::Register;

    unsigned ghosts[Dim];                ///< of the stencil (Walls::ghosts)
    Real least = Real(0);                ///< mass of a node [kg]
    bool ready = false;                  ///< the next ones are known
    Real around = Real(0);               ///< mass of all nodes but those behind walls [kg]
    Lanes inverse[Width * layers];       ///< of the masses of a row's nodes; 0 of a ghost, and of none [1/kg]
    Lanes free[Width * Width * layers];  ///< by node and axis: 1, or 0 where it is held (moves_along())
};

/// The least mass of the stencil's nodes [kg]; nodes: of a tile, from the stencil's first on. Row by row, so that rows
/// do not wait for each other.
template <int Dim, int Width, class Real>
MORAINE_HD Real least_mass(const Quad<Real>* nodes) {
    constexpr int side = tile_side(Width), layers = Dim == 2 ? 1 : Width;
    const auto lesser = [](Real a, Real b) { return b < a ? b : a; };
    Real least = nodes[0][quad - 1];
    for (int k = 0; k < layers; ++k)
        for (int j = 0; j < Width; ++j) {
            const Quad<Real>* row = nodes + 2 * side * (j + side * k);
            Real of_row = row[0][quad - 1];
            for (int i = 1; i < Width; ++i) of_row = lesser(of_row, row[2 * i][quad - 1]);
            least = lesser(least, of_row);
        }
    return least;
}

/// What light nodes ask of a cell's nodes, once for its particles.
template <class Real, int Dim, int Width>
MORAINE_HD void weigh_nodes(const Quad<Real>* nodes, LightCell<Real, Dim, Width>& cell) {
    cell.around = Real(0);
    cell.ready = true;
    constexpr Real rounding = sizeof(Real) == 8 ? Real(1e-12) : Real(1e-5);  // of moves_along()
    using Lanes = typename Quad<Real>::Register;
    const Lanes one = Quad<Real>::all(Real(1)).e, none = Quad<Real>::zero().e;
    each_node<Dim, Width>([&](int at, int i, int j, int k) {
        const Quad<Real>& node = nodes[2 * at];
        const Real m = is_inside<Dim>(cell.ghosts, i, j, k) ? node[quad - 1] : Real(0);
        const int row = j + Width * k;
        cell.around += m;
        if (i == 0) cell.inverse[row] = none;
        cell.inverse[row][i] = m > Real(0) ? Real(1) / m : Real(0);
        const Lanes squares = node.e * node.e;
        Real square = squares[0];
        for (int a = 1; a < Dim; ++a) square += squares[a];
        cell.free[i + Width * row] = squares > rounding * rounding * square ? one : none;
    });
}

/// reactions() of a particle.
template <class Real, int Dim, int Width>
MORAINE_HD Vec<Real, Dim> reactions(const LightStencil<Real, Dim, Width>& n, Real full,
                                    const LightCell<Real, Dim, Width>& cell) {
    using Lanes = typename Quad<Real>::Register;
    Lanes steep[Dim == 3 ? 3 : 2][Width];  // each in its axis' lane
    Real along[quad] = {};
    for (int i = 0; i < Width; ++i) {
        along[i] = n.w[0][i];
        for (int a = 0; a < Dim; ++a) {
            const Real s = steepness(n.w[a][i], n.dw[a][i]);
            steep[a][i] = Lanes{a == 0 ? s : Real(0), a == 1 ? s : Real(0), a == 2 ? s : Real(0), Real(0)};
        }
    }
    const Lanes w = Quad<Real>::load(along).e;
    const Real most = cell.around < full ? cell.around : full;
    Lanes sum = Lanes{};
    for (int k = 0; k < cell.layers; ++k)
        for (int j = 0; j < Width; ++j) {
            const int row = j + Width * k;
            Lanes product = w * n.w[1][j], across = steep[1][j];
            if constexpr (Dim == 3) product *= n.w[Dim - 1][k], across += steep[Dim - 1][k];
            const Lanes ratio = product * (most * cell.inverse[row]);
            const Lanes share = ratio < Real(1) ? product * ratio : product;  // reacting_weight()
            for (int i = 0; i < Width; ++i) sum += (steep[0][i] + across) * (share[i] * cell.free[i + Width * row]);
        }
    Vec<Real, Dim> reaction;
    for (int b = 0; b < Dim; ++b) reaction[b] = sum[b];
    return reaction;
}

}  // namespace moraine
