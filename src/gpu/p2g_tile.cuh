#pragma once
// Writes the tiles of a thread block, once and whole. A ghost node behind a closed wall follows by linear
// extrapolation (core/walls.hpp), so what it was given goes to others, axis by axis:
//
//   sum[wall] += 2 sum[ghost],   sum[next inner] -= sum[ghost],   sum[ghost] = 0

#include "gpu/p2g_planes.cuh"

namespace moraine::gpu {

/// Place of the ghost of one face in a tile, or -1.
template <class Case>
__device__ __forceinline__ int ghost_of(const View<typename Case::Real, Case::dim>& v, int b, int a, int face) {
    const auto& walls = v.context.walls;
    const int ghost = walls.plane[a][face] + (face == 0 ? -1 : 1) - (4 * v.table.position[b][a] - Case::Shape::origin);
    const int inner = ghost + (face == 0 ? 2 : -2);
    // Where the inner node is out of the tile, no cell of the block reaches the ghost.
    return walls.fold[a][face] && ghost >= 0 && ghost < Case::side && inner >= 0 && inner < Case::side ? ghost : -1;
}

/// Spare memory of a thread block for folding: the tiles, sum after sum.
template <class Case>
inline constexpr int fold_sums = 1 + 2 * Case::dim;
template <class Case>
inline constexpr int fold_bytes = Case::blocks* fold_sums<Case>* Case::tile_nodes* int(sizeof(typename Case::Real));

/// Folds what lies in `spare`; called by all threads, after a barrier.
template <class Case>
__device__ void fold_tiles(const View<typename Case::Real, Case::dim>& v, const int* block,
                           typename Case::Real* spare) {
    using Real = typename Case::Real;
    constexpr int side = Case::side, face_nodes = Case::tile_nodes / side, lines = fold_sums<Case> * face_nodes;
    for (int a = 0; a < Case::dim; ++a)
        for (int face = 0; face < 2; ++face) {
            const int stride = a == 0 ? 1 : (a == 1 ? side : side * side), in = face == 0 ? stride : -stride;
            for (int i = thread_now(); i < Case::blocks * lines; i += Case::threads) {
                const int b = block[i / lines];
                const int ghost = b >= 0 && v.table.border[b] != 0 ? ghost_of<Case>(v, b, a, face) : -1;
                if (ghost < 0) continue;
                const int n = i % face_nodes;  // the face's nodes, numbered without axis a
                Real* g = spare + i / face_nodes * Case::tile_nodes + n % stride + n / stride * stride * side +
                          ghost * stride;
                const Real value = *g;
                g[in] += Real(2) * value;
                g[2 * in] -= value;
                *g = Real(0);
            }
            __syncthreads();
        }
}

template <class Case>
__device__ __forceinline__ void store_node(const View<typename Case::Real, Case::dim>& v, int b, int n,
                                           const Row<typename Case::Real> (&sum)[2]) {
    auto* to = v.grid.tiles + (std::size_t(v.grid.tile_of[b]) * Case::tile_nodes + n) * node_reals;
    store_quad(to, sum[0]);
    store_quad(to + quad, sum[1]);
}

/// Tiles from planes; called by all threads, after a barrier. block: -1 where the thread block has none.
template <class Case>
__device__ __forceinline__ void write_tiles(const View<typename Case::Real, Case::dim>& v, const int* block,
                                            bool border, const typename Case::Real* planes,
                                            typename Case::Real* spare) {
    using Real = typename Case::Real;
    constexpr int nodes = Case::tile_nodes, sums = fold_sums<Case>;
    for (int i = thread_now(); i < Case::blocks * nodes; i += Case::threads) {
        const int q = i / nodes, n = i % nodes, b = block[q];
        if (b < 0) continue;
        Row<Real> sum[2];
        sum_planes<Case>(planes + q * Planes<Case>::block, n, sum);
        if (!border) store_node<Case>(v, b, n, sum);
#pragma unroll
        for (int s = 0; border && s < sums; ++s)
            spare[(q * sums + s) * nodes + n] = s <= Case::dim ? sum[0].e[s] : sum[1].e[s - Case::dim - 1];
    }
    if (!border) return;
    __syncthreads();
    fold_tiles<Case>(v, block, spare);
    for (int i = thread_now(); i < Case::blocks * nodes; i += Case::threads) {
        const int q = i / nodes, n = i % nodes, b = block[q];
        if (b < 0) continue;
        Row<Real> sum[2] = {};
#pragma unroll
        for (int s = 0; s < sums; ++s)
            (s <= Case::dim ? sum[0].e[s] : sum[1].e[s - Case::dim - 1]) = spare[(q * sums + s) * nodes + n];
        store_node<Case>(v, b, n, sum);
    }
}

}  // namespace moraine::gpu
