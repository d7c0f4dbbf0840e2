#pragma once
// Sums of one (cell, slice): the 9 nodes of one z-layer of a cell's stencil, in registers.
//
//   per layer   wz m v, V sigma wz and V sigma dwz       per line j   16 products      per node   4 + 6 fma
//
// Momentum (mass, momentum) and force are separate parts, so that a thread may hold one or both.

#include "view.cuh"

namespace lab {

/// Weight and slope of node i: a (f - c)^2 + e, the three pieces of the quadratic spline.
template <class Real>
__device__ __forceinline__ void weight_of(int i, Real f, Real& w, Real& dw) {
    const Real a = i == 1 ? Real(-1) : Real(0.5);
    const Real c = Real(1) - Real(0.5) * Real(i);
    const Real e = i == 1 ? Real(0.75) : Real(0);
    const Real t = f - c;
    dw = (a + a) * t;
    w = a * t * t + e;
}

template <class Real>
struct SliceSums {
    Real momentum[9][4];  ///< mass, then momentum
    Real force[9][3];
};

template <class Real, bool Momentum, bool Force>
__device__ __forceinline__ void clear(SliceSums<Real>& s) {
#pragma unroll
    for (int n = 0; n < 9; ++n) {
#pragma unroll
        for (int q = 0; q < 4; ++q)
            if (Momentum) s.momentum[n][q] = Real(0);
#pragma unroll
        for (int q = 0; q < 3; ++q)
            if (Force) s.force[n][q] = Real(0);
    }
}

/// The outer weights of an axis; the middle ones are 1 - w0 - w2 and -dw0 - dw2.
template <class Real>
__device__ __forceinline__ void outer_weights(Real f, Real (&w)[3], Real (&dw)[3]) {
    const Real g = Real(1) - f;
    w[0] = Real(0.5) * g * g, w[2] = Real(0.5) * f * f, w[1] = Real(1);
    dw[0] = -g, dw[2] = f, dw[1] = Real(0);
}

/// Adds one particle to slice k. In x and in y the middle node takes the sum over the three (weight 1, slope 0);
/// middle_from_sums() makes it a node. Saves 30 of 185 instructions per particle.
template <class Real, bool Momentum, bool Force>
__device__ __forceinline__ void add_particle(const Place<Real>& x, const Row<Real>& v, const Row<Real>& n,
                                             const Row<Real>& t, int k, Real inverse_cell, SliceSums<Real>& s) {
    Real wx[3], wy[3], dx[3], dy[3], wz, dz;
    outer_weights(fraction_of<Real>(x.u[0]), wx, dx);
    outer_weights(fraction_of<Real>(x.u[1]), wy, dy);
    weight_of(k, fraction_of<Real>(x.u[2]), wz, dz);
    Real p[4], a[3], b[3], c[3];
    if (Momentum) {
        p[0] = wz * x.mass;
        for (int q = 0; q < 3; ++q) p[1 + q] = p[0] * v.e[q];
    }
    if (Force) {
        const Real scale = -v.w * inverse_cell;
        const Real sz = scale * wz, sd = scale * dz;
        a[0] = sz * n.e[0], a[1] = sz * t.e[0], a[2] = sz * t.e[2];
        b[0] = a[1], b[1] = sz * n.e[1], b[2] = sz * t.e[1];
        c[0] = sd * t.e[2], c[1] = sd * t.e[1], c[2] = sd * n.e[2];
    }
#pragma unroll
    for (int j = 0; j < 3; ++j) {
        Real pj[4], aj[3], bj[3];
        if (Momentum)
            for (int q = 0; q < 4; ++q) pj[q] = j == 1 ? p[q] : wy[j] * p[q];
        if (Force)
            for (int q = 0; q < 3; ++q) {
                aj[q] = j == 1 ? a[q] : wy[j] * a[q];
                bj[q] = j == 1 ? c[q] : fma(dy[j], b[q], wy[j] * c[q]);
            }
#pragma unroll
        for (int i = 0; i < 3; ++i) {
            const int at = i + 3 * j;
            if (Momentum) {
#pragma unroll
                for (int q = 0; q < 4; ++q)
                    s.momentum[at][q] = i == 1 ? s.momentum[at][q] + pj[q] : fma(wx[i], pj[q], s.momentum[at][q]);
            }
            if (Force) {
#pragma unroll
                for (int q = 0; q < 3; ++q)
                    s.force[at][q] =
                        i == 1 ? s.force[at][q] + bj[q] : fma(dx[i], aj[q], fma(wx[i], bj[q], s.force[at][q]));
            }
        }
    }
}

/// Middle = sum - outer ones, in x, then in y.
template <class Real, bool Momentum, bool Force>
__device__ __forceinline__ void middle_from_sums(SliceSums<Real>& s) {
#pragma unroll
    for (int step = 1; step <= 3; step += 2)
#pragma unroll
        for (int line = 0; line < 3; ++line) {
            const int at = step == 1 ? 3 * line + 1 : line + 3;
#pragma unroll
            for (int q = 0; q < 4; ++q)
                if (Momentum)
                    s.momentum[at][q] = s.momentum[at][q] - s.momentum[at - step][q] - s.momentum[at + step][q];
#pragma unroll
            for (int q = 0; q < 3; ++q)
                if (Force) s.force[at][q] = s.force[at][q] - s.force[at - step][q] - s.force[at + step][q];
        }
}

// Combination of cells into the tile. Planes: one per (slice k, layer cz of cells), so that no two warps
// share one; within a warp at one stencil offset (i, j) all cells write different nodes. A node is two quads,
// (mass, momentum) and (force, -); nodes and rows are padded so that 8 lanes with 16 bytes each fall into
// different banks.
template <class Real>
inline constexpr int plane_node = sizeof(Real) == 4 ? 8 : 10;
template <class Real>
inline constexpr int plane_row = sizeof(Real) == 4 ? 52 : 72;
template <class Real>
inline constexpr int plane_size = 6 * plane_row<Real>;
template <class Real>
inline constexpr int planes_reals = 12 * plane_size<Real>;
template <class Real>
inline constexpr int all_planes_bytes = planes_reals<Real>* int(sizeof(Real));

/// A quad by 16-byte accesses: doubles of the planes are aligned to 16 bytes only.
template <class Real>
__device__ __forceinline__ void load_quad(const Real* from, Real (&q)[4]) {
#pragma unroll
    for (int i = 0; i < int(sizeof(Real)) / 4; ++i)
        reinterpret_cast<uint4*>(q)[i] = reinterpret_cast<const uint4*>(from)[i];
}
template <class Real>
__device__ __forceinline__ void store_quad(Real* to, const Real (&q)[4]) {
#pragma unroll
    for (int i = 0; i < int(sizeof(Real)) / 4; ++i)
        reinterpret_cast<uint4*>(to)[i] = reinterpret_cast<const uint4*>(q)[i];
}

/// Adds this thread's sums to the planes; called by all lanes of a warp.
template <class Real, bool Momentum, bool Force>
__device__ __forceinline__ void add_to_planes(const SliceSums<Real>& s, int k, int cell, Real* planes) {
    const int x = cell & 3, y = (cell >> 2) & 3, z = cell >> 4;
    Real* at = planes + (4 * k + z) * plane_size<Real> + plane_row<Real> * y + plane_node<Real> * x;
#pragma unroll
    for (int j = 0; j < 3; ++j)
#pragma unroll
        for (int i = 0; i < 3; ++i) {
            Real* to = at + plane_row<Real> * j + plane_node<Real> * i;
            const int n = i + 3 * j;
            const bool fresh = (i == 0 || x == 3) && (j == 0 || y == 3);  // nobody wrote this node yet
            alignas(16) Real m[4] = {0, 0, 0, 0};
            alignas(16) Real f[4] = {0, 0, 0, 0};
            if (!fresh) {
                if (Momentum) load_quad(to, m);
                if (Force) load_quad(to + 4, f);
            }
#pragma unroll
            for (int q = 0; q < 4; ++q) {
                if (Momentum) m[q] += s.momentum[n][q];
                if (Force && q < 3) f[q] += s.force[n][q < 3 ? q : 0];
            }
            if (Momentum) store_quad(to, m);
            if (Force) store_quad(to + 4, f);
            __syncwarp();
        }
}

/// Node n of the tile: slices in order.
template <class Real>
__device__ __forceinline__ void sum_planes(const Real* planes, int n, Real (&sum)[7]) {
    const int x = n % side, y = n / side % side, z = n / (side * side);
#pragma unroll
    for (int q = 0; q < 7; ++q) sum[q] = Real(0);
#pragma unroll
    for (int k = 0; k < 3; ++k) {
        const int layer = z - k;
        if (layer < 0 || layer > 3) continue;
        const Real* at = planes + (4 * k + layer) * plane_size<Real> + plane_row<Real> * y + plane_node<Real> * x;
        alignas(16) Real m[4];
        alignas(16) Real f[4];
        load_quad(at, m), load_quad(at + 4, f);
#pragma unroll
        for (int q = 0; q < 7; ++q) sum[q] += q < 4 ? m[q & 3] : f[q & 3];
    }
}

/// Ghost nodes behind walls, transposed: sums[n0] += 2 sums[ghost], sums[n1] -= sums[ghost]. T: 7 x 216 in shared
/// memory.
template <class Real>
__device__ void fold_tile(const View<Real>& v, int b, Real* T) {
    constexpr int stride[3] = {1, side, side * side};
    for (int a = 0; a < 3; ++a)
        for (int s = 0; s < 2; ++s) {
            const int ghost = v.walls.plane[a][s] + (s == 0 ? -1 : 1) - (4 * v.position[b][a] - 1);
            const int in = s == 0 ? 1 : -1;
            if (!v.walls.fold[a][s] || ghost < 0 || ghost >= side || ghost + 2 * in < 0 || ghost + 2 * in >= side)
                continue;
            const int o1 = stride[(a + 1) % 3], o2 = stride[(a + 2) % 3], o = stride[a];
            for (int i = int(threadIdx.x); i < 7 * side * side; i += int(blockDim.x)) {
                Real* line = T + i / (side * side) * tile_nodes + i % side * o1 + i / side % side * o2;
                const Real g = line[ghost * o];
                line[(ghost + in) * o] += Real(2) * g;
                line[(ghost + 2 * in) * o] -= g;
                line[ghost * o] = Real(0);
            }
            __syncthreads();
        }
}

/// Writes the tile of block b; called by the whole thread block, after a barrier. spare: 7 x 216 reals besides the
/// planes.
template <class Real>
__device__ __forceinline__ void write_tile(const View<Real>& v, int b, const Real* planes, Real* spare) {
    Quad<Real>* tile = v.tiles + std::size_t(b) * (2 * tile_nodes);
    const bool border = v.border[b] != 0;
    for (int n = int(threadIdx.x); n < tile_nodes; n += int(blockDim.x)) {
        Real sum[7];
        sum_planes(planes, n, sum);
        if (border) {
            for (int q = 0; q < 7; ++q) spare[q * tile_nodes + n] = sum[q];
        } else {
            store_row(tile + 2 * n, Quad<Real>{{sum[0], sum[1], sum[2], sum[3]}});
            store_row(tile + 2 * n + 1, Quad<Real>{{sum[4], sum[5], sum[6], Real(0)}});
        }
    }
    if (!border) return;
    __syncthreads();
    fold_tile(v, b, spare);
    for (int n = int(threadIdx.x); n < tile_nodes; n += int(blockDim.x)) {
        const Real* s = spare + n;
        store_row(tile + 2 * n, Quad<Real>{{s[0], s[tile_nodes], s[2 * tile_nodes], s[3 * tile_nodes]}});
        store_row(tile + 2 * n + 1, Quad<Real>{{s[4 * tile_nodes], s[5 * tile_nodes], s[6 * tile_nodes], Real(0)}});
    }
}

}  // namespace lab
