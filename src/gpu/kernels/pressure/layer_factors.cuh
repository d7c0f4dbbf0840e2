#pragma once
// What the nodes of cells that are not whole take of them, from the cells' moments, 16 cells at a time: a layer of a
// block in 3-D, all of it in 2-D. In shared memory, where the sums over nodes and over cells read it.

#include "core/fluid/grid_pressure.hpp"
#include "gpu/kernels/pressure/pressure_work.hpp"
#include "gpu/kernels/team.cuh"
#include "gpu/kernels/warp.cuh"

namespace moraine::gpu {

inline constexpr int layer_cells = 16;

template <int Dim>
inline constexpr int layers = Block<Dim>::cells / layer_cells;

/// Threads that share the nodes of a cell.
template <int Dim>
inline constexpr int parts = Team<Dim>::threads / layer_cells;

/// How a cell takes part.
enum CellKind : std::uint8_t { no_part, by_moments, whole_kind };

/// By axis and the cell's place along it.
template <class Real, int Dim>
using BlockBasis = CellBasis<Real>[Dim][Block<Dim>::side];

template <class Real, int Dim>
__device__ __forceinline__ void find_basis(const View<Real, Dim>& v, int block, BlockBasis<Real, Dim>& basis) {
    for (int k = Team<Dim>::rank(); k < Dim * Block<Dim>::side; k += Team<Dim>::threads) {
        const int a = k / Block<Dim>::side, at = k % Block<Dim>::side;
        const int base = first_node<Quadratic>(v.table.position[block][a]) + at;
        basis[a][at] = cell_basis<Real>(v.table.border[block] ? v.context.walls.ghosts(a, base, 3) : 0u);
    }
}

/// The kinds of a block's cells, a bit each.
template <int Dim>
struct KindMasks {
    std::uint8_t kind[Block<Dim>::cells];
    CellBits<Dim> cut;  ///< by moments

    /// Each thread says the kind of the cell of its rank. A sync() must follow.
    __device__ __forceinline__ void tell(CellKind mine) {
        const int c = Team<Dim>::rank();
        const unsigned m = __ballot_sync(all_lanes, mine == by_moments);
        if (c < Block<Dim>::cells) kind[c] = mine;
        if (c % 32 == 0 && c / 32 < cut.words) cut.word[c / 32] = m;
    }
    __device__ __forceinline__ bool any_in(int layer) const {
        return (cut.word[layer / 2] >> (layer % 2 * layer_cells) & 0xffffu) != 0;
    }
};

/// G_ic [m^(d-1)], by axis.
template <class Real, int Dim>
struct LayerFactors {
    static constexpr int nodes = power<Dim>(3);
    Real of[Dim][nodes][layer_cells];

    /// moments: of the block's cells. A sync() must follow.
    __device__ __forceinline__ void find(const CellMoments<Real, Dim>* moments, const KindMasks<Dim>& kinds,
                                         const BlockBasis<Real, Dim>& basis, int layer, Real inverse_cell) {
#pragma unroll 1
        for (int item = Team<Dim>::rank(); item < Dim * 3 * layer_cells; item += Team<Dim>::threads) {
            const int cell = item % layer_cells, i = item / layer_cells % 3, row = item / (3 * layer_cells);
            const int c = layer * layer_cells + cell;
            if (kinds.kind[c] != by_moments) continue;
            const auto coefficients = [&](int a, int node) {
                const CellBasis<Real>& b = basis[a][cell_coordinate<Dim>(c, a)];
                return row == a ? b.slope[node] : b.value[node];
            };
            contract(moments[c].m, i, inverse_cell, coefficients, [&](int n, Real value) { of[row][n][cell] = value; });
        }
    }

    /// Of this thread's part of the nodes: f(node of the stencil, its place in the tile from the cell's first).
    template <class F>
    static __device__ __forceinline__ void each_of_part(const F& f) {
#pragma unroll
        for (int n = Team<Dim>::rank() / layer_cells; n < nodes; n += parts<Dim>)
            f(n, n % 3 + 6 * (n / 3 % 3 + 6 * (n / 9)));
    }

  private:
    /// Axis by axis, for nodes i, j, k of one i.
    template <class Coefficients, class Store>
    static __device__ __forceinline__ void contract(const Real* m, int i, Real scale, const Coefficients& of,
                                                    const Store& store) {
        const auto sum = [](const Real* c, Real a, Real b, Real d) { return c[0] * a + c[1] * b + c[2] * d; };
        Real line[power<Dim - 1>(3)];
        const Real* x = of(0, i);
#pragma unroll
        for (int p = 0; p < power<Dim - 1>(3); ++p) line[p] = scale * sum(x, m[3 * p], m[3 * p + 1], m[3 * p + 2]);
#pragma unroll
        for (int j = 0; j < 3; ++j) {
            const Real* y = of(1, j);
            if constexpr (Dim == 2) {
                store(i + 3 * j, sum(y, line[0], line[1], line[2]));
            } else {
                Real plane[3];
#pragma unroll
                for (int p = 0; p < 3; ++p) plane[p] = sum(y, line[3 * p], line[3 * p + 1], line[3 * p + 2]);
#pragma unroll
                for (int k = 0; k < 3; ++k) store(i + 3 * (j + 3 * k), sum(of(2, k), plane[0], plane[1], plane[2]));
            }
        }
    }
};

}  // namespace moraine::gpu
