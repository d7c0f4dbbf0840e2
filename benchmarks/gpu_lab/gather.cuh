#pragma once
// What a particle reads from the nodes: a tile of 216 nodes in shared memory, and the nested sums over its stencil.
//
// Sums run along x, then y, then z: 9 + 4 + 5/3 products of three per node instead of 18. The cell is the top bits
// of the place, so no cell list is read. Ghost nodes behind walls are set once per tile by linear extrapolation,
// v_-1 = 2 v_0 - v_1: the same as folding each particle's weights, and no particle asks for walls.
// Narrow: v and dv of a node as a quad and a pair (6 reals) instead of two quads.

#include "view.cuh"

namespace lab {

template <class Real>
struct alignas(2 * sizeof(Real)) Pair {
    Real e[2];
};

template <class Real, bool Narrow>
struct NodeTile {
    Quad<Real> velocity[tile_nodes];  ///< narrow: v and dv_x
    Quad<Real> change[Narrow ? 1 : tile_nodes];
    Pair<Real> rest[Narrow ? tile_nodes : 1];

    __device__ __forceinline__ void get(int n, Real (&v)[3], Real (&dv)[3]) const {
        const Quad<Real> q = load_row(velocity + n);
        v[0] = q.e[0], v[1] = q.e[1], v[2] = q.e[2];
        if constexpr (Narrow) {
            const Pair<Real> r = rest[n];
            dv[0] = q.e[3], dv[1] = r.e[0], dv[2] = r.e[1];
        } else {
            const Quad<Real> d = load_row(change + n);
            dv[0] = d.e[0], dv[1] = d.e[1], dv[2] = d.e[2];
        }
    }
    __device__ __forceinline__ void set(int n, const Real (&v)[3], const Real (&dv)[3]) {
        if constexpr (Narrow) {
            velocity[n] = {{v[0], v[1], v[2], dv[0]}};
            rest[n] = {{dv[1], dv[2]}};
        } else {
            velocity[n] = {{v[0], v[1], v[2], Real(0)}};
            change[n] = {{dv[0], dv[1], dv[2], Real(0)}};
        }
    }
};

template <class Real, bool Narrow>
__device__ __forceinline__ void load_tile(const View<Real>& v, int b, NodeTile<Real, Narrow>& tile) {
    for (int n = int(threadIdx.x); n < tile_nodes; n += int(blockDim.x)) {
        const int x = n % side, y = n / side % side, z = n / (side * side);
        const int corner = (x >> 2) | (y >> 2) << 1 | (z >> 2) << 2;
        const int at = (x & 3) | (y & 3) << 2 | (z & 3) << 4;
        const Quad<Real>* from = v.nodes + (std::size_t(v.node_block[b * 8 + corner]) * cells + at) * 2;
        const Quad<Real> u = load_row(from), d = load_row(from + 1);
        tile.set(n, {u.e[0], u.e[1], u.e[2]}, {d.e[0], d.e[1], d.e[2]});
    }
    __syncthreads();
    if (!v.border[b]) return;
    constexpr int stride[3] = {1, side, side * side};
    for (int a = 0; a < 3; ++a)
        for (int s = 0; s < 2; ++s) {
            const int ghost = v.walls.plane[a][s] + (s == 0 ? -1 : 1) - (4 * v.position[b][a] - 1);
            const int in = s == 0 ? 1 : -1;
            if (!v.walls.fold[a][s] || ghost < 0 || ghost >= side || ghost + 2 * in < 0 || ghost + 2 * in >= side)
                continue;
            for (int i = int(threadIdx.x); i < side * side; i += int(blockDim.x)) {
                const int line = i % side * stride[(a + 1) % 3] + i / side * stride[(a + 2) % 3];
                Real v0[3], d0[3], v1[3], d1[3];
                tile.get(line + (ghost + in) * stride[a], v0, d0);
                tile.get(line + (ghost + 2 * in) * stride[a], v1, d1);
                for (int q = 0; q < 3; ++q) v0[q] = Real(2) * v0[q] - v1[q], d0[q] = Real(2) * d0[q] - d1[q];
                tile.set(line + ghost * stride[a], v0, d0);
            }
            __syncthreads();
        }
}

template <class Real>
struct Gathered {
    Real velocity[3], change[3], gradient[3][3];  ///< gradient[b][a] = dv_a / d(x_b / h)
};

/// What to load at stencil node i of a line: the middle node itself, or the difference of the middle and an outer one.
/// Then a line of v and its slope cost 4 products of three, not 6, and a line of dv 2, not 3.
template <class Real>
struct DifferenceTile {
    NodeTile<Real, true> node;
    NodeTile<Real, true> step;  ///< step[n] = node[n + 1] - node[n] along x
};

template <class Real, bool Narrow>
__device__ __forceinline__ void line_of(const NodeTile<Real, Narrow>& tile, int at, const Real (&w)[3],
                                        const Real (&dw)[3], Real (&lv)[3], Real (&ld)[3], Real (&lx)[3]) {
#pragma unroll
    for (int i = 0; i < 3; ++i) {
        Real v[3], d[3];
        tile.get(at + i, v, d);
#pragma unroll
        for (int q = 0; q < 3; ++q) {
            lv[q] = i == 0 ? w[0] * v[q] : fma(w[i], v[q], lv[q]);
            ld[q] = i == 0 ? w[0] * d[q] : fma(w[i], d[q], ld[q]);
            lx[q] = i == 0 ? dw[0] * v[q] : fma(dw[i], v[q], lx[q]);
        }
    }
}
template <class Real>
__device__ __forceinline__ void line_of(const DifferenceTile<Real>& tile, int at, const Real (&w)[3],
                                        const Real (&dw)[3], Real (&lv)[3], Real (&ld)[3], Real (&lx)[3]) {
    Real v[3], d[3];
    tile.node.get(at + 1, lv, ld);
    tile.step.get(at, v, d);
#pragma unroll
    for (int q = 0; q < 3; ++q) lv[q] = fma(-w[0], v[q], lv[q]), ld[q] = fma(-w[0], d[q], ld[q]), lx[q] = -dw[0] * v[q];
    tile.step.get(at + 1, v, d);
#pragma unroll
    for (int q = 0; q < 3; ++q)
        lv[q] = fma(w[2], v[q], lv[q]), ld[q] = fma(w[2], d[q], ld[q]), lx[q] = fma(dw[2], v[q], lx[q]);
}

template <class Real>
__device__ __forceinline__ void take_steps(DifferenceTile<Real>& tile) {
    for (int n = int(threadIdx.x); n < tile_nodes - 1; n += int(blockDim.x)) {
        Real v[3], d[3], v1[3], d1[3];
        tile.node.get(n, v, d), tile.node.get(n + 1, v1, d1);
        for (int q = 0; q < 3; ++q) v1[q] -= v[q], d1[q] -= d[q];
        tile.step.set(n, v1, d1);
    }
    __syncthreads();
}

template <class Real, class Tile>
__device__ __forceinline__ Gathered<Real> gather(const Tile& tile, const Place<Real>& x) {
    Real w[3][3], dw[3][3];
    int at = 0;
#pragma unroll
    for (int a = 2; a >= 0; --a) {
        Quadratic::weights(fraction_of<Real>(x.u[a]), Real(0), w[a], dw[a]);
        at = at * side + cell_of<Real>(x.u[a]);
    }
    Gathered<Real> g;
#pragma unroll
    for (int k = 0; k < 3; ++k) {
        Real pv[3], pd[3], px[3], py[3];
#pragma unroll
        for (int j = 0; j < 3; ++j) {
            Real lv[3], ld[3], lx[3];
            line_of(tile, at + side * (j + side * k), w[0], dw[0], lv, ld, lx);
#pragma unroll
            for (int q = 0; q < 3; ++q) {
                pv[q] = j == 0 ? w[1][0] * lv[q] : fma(w[1][j], lv[q], pv[q]);
                pd[q] = j == 0 ? w[1][0] * ld[q] : fma(w[1][j], ld[q], pd[q]);
                px[q] = j == 0 ? w[1][0] * lx[q] : fma(w[1][j], lx[q], px[q]);
                py[q] = j == 0 ? dw[1][0] * lv[q] : fma(dw[1][j], lv[q], py[q]);
            }
        }
#pragma unroll
        for (int q = 0; q < 3; ++q) {
            g.velocity[q] = k == 0 ? w[2][0] * pv[q] : fma(w[2][k], pv[q], g.velocity[q]);
            g.change[q] = k == 0 ? w[2][0] * pd[q] : fma(w[2][k], pd[q], g.change[q]);
            g.gradient[0][q] = k == 0 ? w[2][0] * px[q] : fma(w[2][k], px[q], g.gradient[0][q]);
            g.gradient[1][q] = k == 0 ? w[2][0] * py[q] : fma(w[2][k], py[q], g.gradient[1][q]);
            g.gradient[2][q] = k == 0 ? dw[2][0] * pv[q] : fma(dw[2][k], pv[q], g.gradient[2][q]);
        }
    }
    return g;
}

}  // namespace lab
