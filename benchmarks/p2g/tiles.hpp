#pragma once
// Variants that sum each block into its private tile, as the program does.

#include <array>

#include "p2g/variant.hpp"

namespace moraine {

template <class Real>
struct Tiles {
    explicit Tiles(Sample<Real>& s) : sample(s) {
        sums.resize(static_cast<std::size_t>(s.blocks()) * Sample<Real>::tile_nodes * node_reals);
        std::fill_n(sums.data(), sums.size(), Real(0));
    }

    Real* tile(int block) {
        return sums.data() + static_cast<std::size_t>(block) * Sample<Real>::tile_nodes * node_reals;
    }

    /// Adds the tiles to the grid, block after block.
    void bring(GridSums<Real>& grid) {
        constexpr int side = tile_side(3);
        std::fill(grid.begin(), grid.end(), Real(0));
        for (int b = 0; b < sample.blocks(); ++b)
            for (int z = 0; z < side; ++z)
                for (int y = 0; y < side; ++y) {
                    const Real* from = tile(b) + side * (y + side * z) * node_reals;
                    Real* to = grid.data() + (sample.corner(b) + sample.node(0, y, z)) * node_reals;
                    for (int k = 0; k < side * node_reals; ++k) to[k] += from[k];
                }
    }

    /// f(block, cell, first slot, end slot, where the cell's stencil starts in the tile)
    template <class F>
    void each_cell(const F& f) {
        for (int b = 0; b < sample.blocks(); ++b) {
            std::fill_n(tile(b), Sample<Real>::tile_nodes * node_reals, Real(0));
            const std::uint32_t* bounds =
                sample.cell_first.data() + static_cast<std::size_t>(b) * (Block<3>::cells + 1);
            for (int c = 0; c < Block<3>::cells; ++c)
                f(sample.first[static_cast<std::size_t>(b)] + bounds[c],
                  sample.first[static_cast<std::size_t>(b)] + bounds[c + 1],
                  tile(b) + tile_offset<3, 3>(c) * node_reals);
        }
    }

    Sample<Real>& sample;
    Host::Array<Real> sums;
};

/// Four fused multiply-adds and their weights at every node.
template <class Real>
MORAINE_HD void add_by_products(const Brought<Real>& p, Quad<Real>* sums) {
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j) {
            const Real wyz = p.n.w[1][j] * p.n.w[2][k];
            const Real dyz = p.n.dw[1][j] * p.n.w[2][k];
            const Real ydz = p.n.w[1][j] * p.n.dw[2][k];
            for (int i = 0; i < 3; ++i) {
                Quad<Real>* to = sums + 2 * (i + 3 * (j + 3 * k));
                to[0] = fma(p.n.w[0][i] * wyz, p.carried, to[0]);
                Quad<Real> force = fma(p.n.dw[0][i] * wyz, p.traction[0], to[1]);
                force = fma(p.n.w[0][i] * dyz, p.traction[1], force);
                to[1] = fma(p.n.w[0][i] * ydz, p.traction[2], force);
            }
        }
}

/// What a row of three nodes shares is made once: three fused multiply-adds at every node.
template <class Real>
MORAINE_HD void add_by_rows(const Brought<Real>& p, Quad<Real>* sums) {
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j) {
            const Real wyz = p.n.w[1][j] * p.n.w[2][k];
            const Quad<Real> carried = wyz * p.carried;
            const Quad<Real> along = wyz * p.traction[0];
            const Quad<Real> across =
                fma(p.n.w[1][j] * p.n.dw[2][k], p.traction[2], (p.n.dw[1][j] * p.n.w[2][k]) * p.traction[1]);
            for (int i = 0; i < 3; ++i) {
                Quad<Real>* to = sums + 2 * (i + 3 * (j + 3 * k));
                to[0] = fma(p.n.w[0][i], carried, to[0]);
                to[1] = fma(p.n.dw[0][i], along, fma(p.n.w[0][i], across, to[1]));
            }
        }
}

/// As add_by_rows, into nodes that lie anywhere: at(i, j, k) is where a node's reals are.
template <class Real, class At>
MORAINE_HD void add_in_place(const Brought<Real>& p, const At& at) {
    using Q = Quad<Real>;
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j) {
            const Real wyz = p.n.w[1][j] * p.n.w[2][k];
            const Q carried = wyz * p.carried;
            const Q along = wyz * p.traction[0];
            const Q across =
                fma(p.n.w[1][j] * p.n.dw[2][k], p.traction[2], (p.n.dw[1][j] * p.n.w[2][k]) * p.traction[1]);
            for (int i = 0; i < 3; ++i) {
                Real* to = at(i, j, k);
                fma(p.n.w[0][i], carried, Q::load(to)).store(to);
                fma(p.n.dw[0][i], along, fma(p.n.w[0][i], across, Q::load(to + quad))).store(to + quad);
            }
        }
}

/// Adds a cell's sums to its tile.
template <class Real>
MORAINE_HD void add_stencil(const Quad<Real>* sums, Real* to) {
    each_node<3, 3>([&](int at, int i, int j, int k) {
        for (int half = 0; half < 2; ++half) {
            Real* q = to + at * node_reals + half * quad;
            (Quad<Real>::load(q) + sums[2 * (i + 3 * (j + 3 * k)) + half]).store(q);
        }
    });
}

template <class Real, bool Rows>
void sum_cells(Tiles<Real>& tiles) {
    const auto p = tiles.sample.view();
    const auto context = tiles.sample.context();
    Quad<Real> sums[54];
    tiles.each_cell([&](std::uint32_t from, std::uint32_t end, Real* to) {
        for (Quad<Real>& q : sums) q = Quad<Real>::zero();
        for (std::uint32_t k = from; k < end; ++k) {
            const Brought<Real> b(context, p, tiles.sample.slot[k]);
            if constexpr (Rows)
                add_by_rows(b, sums);
            else
                add_by_products(b, sums);
        }
        add_stencil(sums, to);
    });
}

/// Each particle into the tile itself, without sums per cell.
template <class Real>
void sum_straight(Tiles<Real>& tiles) {
    const auto p = tiles.sample.view();
    const auto context = tiles.sample.context();
    tiles.each_cell([&](std::uint32_t from, std::uint32_t end, Real* to) {
        constexpr int side = tile_side(3);
        for (std::uint32_t k = from; k < end; ++k)
            add_in_place(Brought<Real>(context, p, tiles.sample.slot[k]),
                         [&](int i, int j, int l) { return to + (i + side * (j + side * l)) * node_reals; });
    });
}

/// As sum_cells, one number at a time.
template <class Real>
__attribute__((optimize("no-tree-vectorize", "no-tree-slp-vectorize"))) void sum_scalars(Tiles<Real>& tiles) {
    const auto p = tiles.sample.view();
    const auto context = tiles.sample.context();
    std::array<Real, 27 * node_reals> sums;
    tiles.each_cell([&](std::uint32_t from, std::uint32_t end, Real* to) {
        sums.fill(Real(0));
        for (std::uint32_t s = from; s < end; ++s) {
            const Brought<Real> b(context, p, tiles.sample.slot[s]);
            for (int n = 0; n < 27; ++n) {
                const int i = n % 3, j = n / 3 % 3, k = n / 9;
                const Real w = b.n.w[0][i] * b.n.w[1][j] * b.n.w[2][k];
                const Real d[3] = {b.n.dw[0][i] * b.n.w[1][j] * b.n.w[2][k], b.n.w[0][i] * b.n.dw[1][j] * b.n.w[2][k],
                                   b.n.w[0][i] * b.n.w[1][j] * b.n.dw[2][k]};
                Real* q = sums.data() + n * node_reals;
                for (int a = 0; a < 4; ++a) q[a] = std::fma(w, b.carried[a], q[a]);
                for (int a = 0; a < 3; ++a)
                    for (int c = 0; c < 3; ++c) q[quad + a] = std::fma(d[c], b.traction[c][a], q[quad + a]);
            }
        }
        each_node<3, 3>([&](int at, int i, int j, int k) {
            for (int r = 0; r < node_reals; ++r)
                to[at * node_reals + r] += sums[static_cast<std::size_t>((i + 3 * (j + 3 * k)) * node_reals + r)];
        });
    });
}

}  // namespace moraine
