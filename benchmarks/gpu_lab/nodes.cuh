#pragma once
// Nodes: +0 plus up to 8 tiles by offset delta; velocity, gravity, walls (src/core/nodes.hpp). One thread per node.

#include "view.cuh"

namespace lab {

/// Sum of the tiles over node n of node block c; whether any tile covers it.
template <class Real>
__device__ __forceinline__ bool sum_tiles(const View<Real>& v, int c, int n, Quad<Real>& momentum, Quad<Real>& force) {
    momentum = force = Quad<Real>::zero();
    const int x[3] = {n & 3, (n >> 2) & 3, n >> 4};
    bool any = false;
#pragma unroll
    for (int delta = 0; delta < 8; ++delta) {
        const int b = v.source[c * 8 + delta];
        if (b < 0 || v.first[b + 1] == v.first[b]) continue;
        any = true;
        int at = 0;
        bool covered = true;
#pragma unroll
        for (int a = 2; a >= 0; --a) {
            const int upper = (delta >> a) & 1;
            covered = covered && !(upper && x[a] >= 2);
            at = at * side + x[a] + 4 * upper;
        }
        if (!covered) continue;
        const Quad<Real>* from = v.tiles + (std::size_t(b) * tile_nodes + at) * 2;
        const Quad<Real> m = load_row(from), f = load_row(from + 1);
        momentum = momentum + m;
        force = force + f;
    }
    return any;
}

/// One node: v' and dv from the sums.
template <class Real>
__device__ __forceinline__ void solve_node(const View<Real>& v, int c, int n, const Quad<Real>& momentum,
                                           const Quad<Real>& force) {
    Quad<Real> out = Quad<Real>::zero(), change = Quad<Real>::zero();
    const Real m = momentum[0];
    const Real dt = Real(*v.dt);
    if (m > v.mass_cutoff) {
        const Real inverse = Real(1) / m;
        Vec<Real, 3> start, u;
        for (int a = 0; a < 3; ++a) {
            start[a] = momentum[1 + a] * inverse;
            u[a] = start[a] + dt * (force[a] * inverse + v.gravity[a]);
        }
        if (v.border[c]) {
            int node[3];
            for (int a = 0; a < 3; ++a) node[a] = 4 * v.position[c][a] - 1 + ((n >> (2 * a)) & 3);
            v.walls.constrain(node, u);
        }
        for (int a = 0; a < 3; ++a) out[a] = u[a], change[a] = u[a] - start[a];
    }
    Quad<Real>* to = v.nodes + (std::size_t(c) * cells + n) * 2;
    store_row(to, out);
    store_row(to + 1, change);
}

template <class Real>
__global__ void __launch_bounds__(256) solve_nodes(const __grid_constant__ View<Real> v) {
    const int item = int(blockIdx.x) * 4 + int(threadIdx.x) / 64;
    if (item >= v.node_blocks) return;
    const int c = v.chosen(item, v.node_blocks), n = int(threadIdx.x) & 63;
    Quad<Real> momentum, force;
    if (sum_tiles(v, c, n, momentum, force)) solve_node(v, c, n, momentum, force);
}

/// The sums themselves, for checks and for the variants that need no tiles.
template <class Real>
__global__ void __launch_bounds__(256) store_sums(const __grid_constant__ View<Real> v, Quad<Real>* sums) {
    const int c = int(blockIdx.x) * 4 + int(threadIdx.x) / 64, n = int(threadIdx.x) & 63;
    if (c >= v.node_blocks) return;
    Quad<Real> momentum, force;
    sum_tiles(v, c, n, momentum, force);
    store_row(sums + (std::size_t(c) * cells + n) * 2, momentum);
    store_row(sums + (std::size_t(c) * cells + n) * 2 + 1, force);
}

}  // namespace lab
