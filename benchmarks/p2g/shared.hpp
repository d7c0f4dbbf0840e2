#pragma once
// Variants without tiles: all blocks share the nodes of one grid.

#include "p2g/tiles.hpp"

namespace moraine {

/// Lowest node of the stencil of a block's cell on the grid.
template <class Real>
std::size_t stencil_start(const Sample<Real>& s, int block, int cell) {
    return s.corner(block) +
           s.node(cell_coordinate<3>(cell, 0), cell_coordinate<3>(cell, 1), cell_coordinate<3>(cell, 2));
}

/// f(slot, lowest node) for the particles of some blocks, in list order.
template <class Real, class F>
void each_listed(const Sample<Real>& s, int first_block, int end_block, const F& f) {
    for (int b = first_block; b < end_block; ++b) {
        const std::uint32_t* bounds = s.cell_first.data() + static_cast<std::size_t>(b) * (Block<3>::cells + 1);
        for (int c = 0; c < Block<3>::cells; ++c) {
            const std::size_t start = stencil_start(s, b, c);
            for (std::uint32_t k = bounds[c]; k < bounds[c + 1]; ++k)
                f(s.slot[s.first[static_cast<std::size_t>(b)] + k], start);
        }
    }
}

/// One thread scatters all particles to the grid.
template <class Real>
void scatter(Sample<Real>& s, GridSums<Real>& grid) {
    const auto p = s.view();
    const auto context = s.context();
    std::fill(grid.begin(), grid.end(), Real(0));
    each_listed(s, 0, s.blocks(), [&](std::uint32_t slot, std::size_t start) {
        add_in_place(Brought<Real>(context, p, slot),
                     [&](int i, int j, int k) { return grid.data() + (start + s.node(i, j, k)) * node_reals; });
    });
}

/// Threads scatter their blocks' particles with atomic adds.
template <class Real>
void scatter_atomic(Sample<Real>& s, GridSums<Real>& grid, int threads) {
    const auto p = s.view();
    const auto context = s.context();
    std::fill(grid.begin(), grid.end(), Real(0));
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int b = 0; b < s.blocks(); ++b)
        each_listed(s, b, b + 1, [&](std::uint32_t slot, std::size_t start) {
            Quad<Real> brought[54];
            for (Quad<Real>& q : brought) q = Quad<Real>::zero();
            add_by_rows(Brought<Real>(context, p, slot), brought);
            for (int n = 0; n < 27; ++n) {
                Real* to = grid.data() + (start + s.node(n % 3, n / 3 % 3, n / 9)) * node_reals;
                for (int r = 0; r < 7; ++r) {
                    const Real add = brought[2 * n + r / quad][r % quad];
#pragma omp atomic
                    to[r] += add;
                }
            }
        });
}

/// A list of particles for each node, made anew as the program would have to, and one gather per node.
template <class Real>
struct NodeLists {
    explicit NodeLists(const Sample<Real>& s)
        : first(s.grid_nodes() + 1), entry(static_cast<std::size_t>(s.particles()) * 27) {}

    struct Entry {
        std::uint32_t slot;
        std::uint32_t corner;  ///< which node of the particle's stencil this is
    };

    void make(const Sample<Real>& s) {
        std::fill(first.begin(), first.end(), 0u);
        each_listed(s, 0, s.blocks(), [&](std::uint32_t, std::size_t start) {
            for (int n = 0; n < 27; ++n) ++first[start + s.node(n % 3, n / 3 % 3, n / 9) + 1];
        });
        for (std::size_t n = 1; n < first.size(); ++n) first[n] += first[n - 1];
        std::vector<std::uint32_t> at(first.begin(), first.end() - 1);
        each_listed(s, 0, s.blocks(), [&](std::uint32_t slot, std::size_t start) {
            for (int n = 0; n < 27; ++n)
                entry[at[start + s.node(n % 3, n / 3 % 3, n / 9)]++] = {slot, static_cast<std::uint32_t>(n)};
        });
    }

    void gather(Sample<Real>& s, GridSums<Real>& grid) const {
        const auto p = s.view();
        const auto context = s.context();
        for (std::size_t node = 0; node + 1 < first.size(); ++node) {
            Quad<Real> carried = Quad<Real>::zero(), force = Quad<Real>::zero();
            for (std::uint32_t e = first[node]; e < first[node + 1]; ++e) {
                const Brought<Real> b(context, p, entry[e].slot);
                const auto n = static_cast<int>(entry[e].corner);
                const int i = n % 3, j = n / 3 % 3, k = n / 9;
                const Real wyz = b.n.w[1][j] * b.n.w[2][k];
                carried = fma(b.n.w[0][i] * wyz, b.carried, carried);
                force = fma(b.n.dw[0][i] * wyz, b.traction[0], force);
                force = fma(b.n.w[0][i] * (b.n.dw[1][j] * b.n.w[2][k]), b.traction[1], force);
                force = fma(b.n.w[0][i] * (b.n.w[1][j] * b.n.dw[2][k]), b.traction[2], force);
            }
            carried.store(grid.data() + node * node_reals);
            force.store(grid.data() + node * node_reals + quad);
        }
    }

    std::vector<std::uint32_t> first;
    std::vector<Entry> entry;
};

}  // namespace moraine
