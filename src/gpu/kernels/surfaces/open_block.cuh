#pragma once
// How the kernels of cells beside surfaces see a giver's cells and what their nodes hold (core/surfaces/open_rule.hpp):
// a thread block per giver, a thread per cell, then a thread per node of the tile, which adds up what the cells around
// it give.

#include "core/surfaces/open_rule.hpp"
#include "gpu/kernels/pressure/pressure_work.hpp"
#include "gpu/kernels/surfaces/surface_nodes.cuh"

namespace moraine::gpu {

/// What the nodes of a cell hold (core/surfaces/open_rule.hpp).
template <class Real, int Dim>
struct OpenNodes {
    const OpenWork<Real, Dim>& w;
    const TileNodes<Dim>& nodes;
    int corner;

    __device__ __forceinline__ const Real* values(int at) const { return nodes.values(w, corner + at); }
    __device__ __forceinline__ const SpaceNode& node(int at) const {
        const std::int32_t near = nodes.near[corner + at];
        return w.open.node[near / Block<Dim>::cells][near % Block<Dim>::cells];
    }
    __device__ __forceinline__ double distance(int at) const { return node(at).distance; }
    __device__ __forceinline__ double capacity(int at) const { return node(at).capacity; }
    __device__ __forceinline__ double filling(int at) const {
        return double(w.pressure.held[nodes.place[corner + at]].filling);
    }
};

/// A giver's cells.
template <class Real, int Dim>
struct OpenBlock : Giver<Real, Dim> {
    static constexpr int cells = Block<Dim>::cells;
    using Base = Giver<Real, Dim>;
    const OpenWork<Real, Dim>& all;

    __device__ __forceinline__ explicit OpenBlock(const OpenWork<Real, Dim>& w) : Base{w}, all(w) {}
    __device__ __forceinline__ OpenCell<Real, Dim>& cell(int c) const { return all.open.cell[this->g * cells + c]; }
    __device__ __forceinline__ const SurfaceCell<Dim>& place(int c) const { return this->bed.cells[c]; }
    __device__ __forceinline__ std::uint32_t particles() const { return all.view.list.count(this->block); }
    /// Of the grid's own pressures; the block is occupied.
    __device__ __forceinline__ CellPressure<Real>& pressure(int c) const {
        return all.pressure.cell[std::size_t(all.view.grid.tile_of[this->block]) * cells + std::size_t(c)];
    }
    /// The tile's node in the middle of the cell with which a cell has its pressure, which may be itself.
    __device__ __forceinline__ int root_node(int c) const {
        int n = tile_offset<Dim, 3>(c) + to_middle<Dim>;
        for (int a = 0, stride = 1; a < Dim && cell(c).child; ++a, stride *= tile_side(3))
            n += stride * place(c).root[a];
        return n;
    }
    __device__ __forceinline__ const Real* sum_at(const TileNodes<Dim>& nodes, int n) const {
        return all.open.sums + std::size_t(nodes.near[n]) * node_reals;
    }
    /// give(n, sum): adds what node n of the tile gets to the lanes of `sum`, zeros. By all threads.
    template <class Give>
    __device__ __forceinline__ void fill_tile(const Give& give) const {
        for (int n = static_cast<int>(threadIdx.x); n < surface_tile<Dim>; n += surface_threads) {
            Real sum[node_reals];
            for (int q = 0; q < node_reals; ++q) sum[q] = Real(0);
            give(n, sum);
            for (int q = 0; q < node_reals; ++q) this->tile()[n * node_reals + q] = sum[q];
        }
    }
    /// The same of the first quad alone.
    template <class Give>
    __device__ __forceinline__ void fill_quads(const Give& give) const {
        for (int n = static_cast<int>(threadIdx.x); n < surface_tile<Dim>; n += surface_threads) {
            Quad<Real> sum = Quad<Real>::zero();
            give(n, sum);
            store_row(reinterpret_cast<Quad<Real>*>(this->tile() + n * node_reals), sum);
        }
    }
    /// f(c, i) of the cells whose stencil has node n of the tile as its node i, ascending.
    template <class F>
    static __device__ __forceinline__ void each_cell(int n, const F& f) {
        constexpr int side = tile_side(3);
        int at[3] = {0, 0, 0};
        for (int a = 0, rest = n; a < Dim; ++a, rest /= side) at[a] = rest % side;
        for (int z = Dim == 3 ? 2 : 0; z >= 0; --z)
            for (int y = 2; y >= 0; --y)
                for (int x = 2; x >= 0; --x) {
                    const int cx = at[0] - x, cy = at[1] - y, cz = at[2] - z;
                    const bool is = cx >= 0 && cx < 4 && cy >= 0 && cy < 4 && cz >= 0 && cz < 4;
                    if (is) f(cx + 4 * (cy + 4 * cz), x + 3 * (y + 3 * z));
                }
    }
};

}  // namespace moraine::gpu
