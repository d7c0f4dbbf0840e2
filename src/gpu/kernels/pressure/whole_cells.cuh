#pragma once
// Whole cells of a block and their nodes: gradients and divergences are products over the axes, w = (1/6, 2/3, 1/6)
// and g = (-1/2, 0, 1/2), so that a sum over 3^d goes axis by axis. All threads of a team call these; each ends with
// all of it seen.

#include "core/data/block.hpp"
#include "core/grid/shape.hpp"
#include "gpu/kernels/team.cuh"

namespace moraine::gpu {

inline constexpr int cells_along = 4, nodes_along = 6;

template <class Real>
__device__ __forceinline__ constexpr Real whole_weight(int i) {
    return i == 1 ? Real(2.0 / 3) : Real(1.0 / 6);
}
template <class Real>
__device__ __forceinline__ constexpr Real whole_slope(int i) {
    return Real(0.5) * Real(i - 1);
}

/// Sums of which one axis is done after the other.
template <class Real, int Dim>
struct AxisSums {
    static constexpr int wide = Dim == 3 ? nodes_along * nodes_along * cells_along : nodes_along * cells_along;
    static constexpr int narrow = Dim == 3 ? nodes_along * cells_along * cells_along : 1;
    Real near[3][wide];  ///< of the axes but the last, in nodes; of that in cells
    Real far[2][narrow];
};

template <int Dim, class F>
__device__ __forceinline__ void each_item(int n, const F& f) {
    for (int k = Team<Dim>::rank(); k < n; k += Team<Dim>::threads) f(k);
    Team<Dim>::sync();
}

/// sum_i over the nodes of cell x along an axis; at(node).
template <class Real, class Factor, class At>
__device__ __forceinline__ Real over_nodes(int x, const Factor& factor, const At& at) {
    return factor(0) * at(x) + factor(1) * at(x + 1) + factor(2) * at(x + 2);
}

/// sum_c over the cells that reach node X along an axis; at(cell).
template <class Real, class Factor, class At>
__device__ __forceinline__ Real over_cells(int X, const Factor& factor, const At& at) {
    Real sum = Real(0);
#pragma unroll
    for (int i = 2; i >= 0; --i) {
        const int x = X - i;
        if (x >= 0 && x < cells_along) sum += factor(i) * at(x);
    }
    return sum;
}

/// The gradients: f(node, for each axis a sum_c of g along a, w along the others, p). p: of the cells, 0 where a cell
/// is not whole.
template <class Real, int Dim, class F>
__device__ __forceinline__ void sum_whole(const Real* p, AxisSums<Real, Dim>& s, const F& f) {
    const auto w = [](int i) { return whole_weight<Real>(i); };
    const auto g = [](int i) { return whole_slope<Real>(i); };
    if constexpr (Dim == 2) {
        each_item<Dim>(nodes_along * cells_along, [&](int k) {
            const int X = k % nodes_along, y = k / nodes_along;
            const auto at = [&](int x) { return p[x + cells_along * y]; };
            s.near[0][k] = over_cells<Real>(X, w, at);
            s.near[1][k] = over_cells<Real>(X, g, at);
        });
        each_item<Dim>(nodes_along * nodes_along, [&](int n) {
            const int X = n % nodes_along, Y = n / nodes_along;
            const Real sums[2] = {over_cells<Real>(Y, w, [&](int y) { return s.near[1][X + nodes_along * y]; }),
                                  over_cells<Real>(Y, g, [&](int y) { return s.near[0][X + nodes_along * y]; })};
            f(n, sums);
        });
    } else {
        each_item<Dim>(s.narrow, [&](int k) {
            const int X = k % nodes_along, yz = k / nodes_along;
            const auto at = [&](int x) { return p[x + cells_along * yz]; };
            s.far[0][k] = over_cells<Real>(X, w, at);
            s.far[1][k] = over_cells<Real>(X, g, at);
        });
        each_item<Dim>(s.wide, [&](int k) {
            const int X = k % nodes_along, Y = k / nodes_along % nodes_along, z = k / (nodes_along * nodes_along);
            const auto from = [&](int which) {
                return [&, which](int y) { return s.far[which][X + nodes_along * (y + cells_along * z)]; };
            };
            s.near[0][k] = over_cells<Real>(Y, w, from(0));
            s.near[1][k] = over_cells<Real>(Y, w, from(1));
            s.near[2][k] = over_cells<Real>(Y, g, from(0));
        });
        each_item<Dim>(nodes_along * nodes_along * nodes_along, [&](int n) {
            const int XY = n % (nodes_along * nodes_along), Z = n / (nodes_along * nodes_along);
            const auto from = [&](int which) {
                return [&, which](int z) { return s.near[which][XY + nodes_along * nodes_along * z]; };
            };
            const Real sums[3] = {over_cells<Real>(Z, w, from(1)), over_cells<Real>(Z, w, from(2)),
                                  over_cells<Real>(Z, g, from(0))};
            f(n, sums);
        });
    }
}

/// The divergences: f(cell, sum_i of g w w v_x + w g w v_y + ...). v: by axis and node of
/// the tile.
template <class Real, int Dim, class F>
__device__ __forceinline__ void divergence_of_whole(const Real (*v)[power<Dim>(nodes_along)], AxisSums<Real, Dim>& s,
                                                    const F& f) {
    const auto w = [](int i) { return whole_weight<Real>(i); };
    const auto g = [](int i) { return whole_slope<Real>(i); };
    if constexpr (Dim == 2) {
        each_item<Dim>(nodes_along * cells_along, [&](int k) {
            const int X = k % nodes_along, y = k / nodes_along;
            s.near[0][k] = over_nodes<Real>(y, w, [&](int Y) { return v[0][X + nodes_along * Y]; });
            s.near[1][k] = over_nodes<Real>(y, g, [&](int Y) { return v[1][X + nodes_along * Y]; });
        });
        each_item<Dim>(cells_along * cells_along, [&](int c) {
            const int x = c % cells_along, row = nodes_along * (c / cells_along);
            f(c, over_nodes<Real>(x, g, [&](int X) { return s.near[0][X + row]; }) +
                     over_nodes<Real>(x, w, [&](int X) { return s.near[1][X + row]; }));
        });
    } else {
        each_item<Dim>(s.wide, [&](int k) {
            const int XY = k % (nodes_along * nodes_along), z = k / (nodes_along * nodes_along);
            const auto from = [&](int a) { return [&, a](int Z) { return v[a][XY + nodes_along * nodes_along * Z]; }; };
            s.near[0][k] = over_nodes<Real>(z, w, from(0));
            s.near[1][k] = over_nodes<Real>(z, w, from(1));
            s.near[2][k] = over_nodes<Real>(z, g, from(2));
        });
        each_item<Dim>(s.narrow, [&](int k) {
            const int X = k % nodes_along, y = k / nodes_along % cells_along, z = k / (nodes_along * cells_along);
            const auto from = [&](int which) {
                return [&, which](int Y) { return s.near[which][X + nodes_along * (Y + nodes_along * z)]; };
            };
            s.far[0][k] = over_nodes<Real>(y, w, from(0));
            s.far[1][k] = over_nodes<Real>(y, g, from(1)) + over_nodes<Real>(y, w, from(2));
        });
        each_item<Dim>(cells_along * cells_along * cells_along, [&](int c) {
            const int x = c % cells_along, row = nodes_along * (c / cells_along);
            f(c, over_nodes<Real>(x, g, [&](int X) { return s.far[0][X + row]; }) +
                     over_nodes<Real>(x, w, [&](int X) { return s.far[1][X + row]; }));
        });
    }
}

/// sum_i of g along b, w along the others, times v_a: L h^(1 - d) of a whole cell, by one thread. v: of its first node.
template <class Real, int Dim>
__device__ __forceinline__ Mat<Real, Dim> gradient_of_whole(const Vec<Real, Dim>* v) {
    Mat<Real, Dim> L = zero_mat<Real, Dim>();
#pragma unroll
    for (int n = 0; n < power<Dim>(3); ++n) {
        const int place[3] = {n % 3, n / 3 % 3, n / 9};
        const Vec<Real, Dim>& of = v[place[0] + nodes_along * (place[1] + nodes_along * place[2])];
#pragma unroll
        for (int b = 0; b < Dim; ++b) {
            Real g = Real(1);
#pragma unroll
            for (int a = 0; a < Dim; ++a) g *= a == b ? whole_slope<Real>(place[a]) : whole_weight<Real>(place[a]);
            if (place[b] == 1) continue;  // no slope there
#pragma unroll
            for (int a = 0; a < Dim; ++a) L(a, b) += g * of[a];
        }
    }
    return L;
}

}  // namespace moraine::gpu
