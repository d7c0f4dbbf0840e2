#pragma once
// Writes the tiles of a thread block, once and whole. A ghost node behind a closed wall follows by linear
// extrapolation (core/grid/walls.hpp), so what it was given goes to others, axis by axis:
//
//   sum[wall] += 2 sum[ghost],   sum[next inner] -= sum[ghost],   sum[ghost] = 0

#include "gpu/kernels/p2g/p2g_planes.cuh"

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

/// Folds quads [part][block][node] in shared memory; called by all threads, after a barrier, and ends with one.
template <class Case, int Parts>
__device__ void fold_tiles(const View<typename Case::Real, Case::dim>& v, const int* block,
                           typename Case::Real* quads) {
    using Real = typename Case::Real;
    constexpr int side = Case::side, lines = Case::tile_nodes / side;
    for (int a = 0; a < Case::dim; ++a)
        for (int face = 0; face < 2; ++face) {
            const int stride = a == 0 ? 1 : (a == 1 ? side : side * side), in = face == 0 ? stride : -stride;
            for (int i = int(thread_now()); i < Parts * Case::blocks * lines * quad; i += Case::threads) {
                const int tile = i / (lines * quad), line = i / quad % lines;  // lines along axis a
                const int b = block[tile % Case::blocks];
                const int ghost = b >= 0 && v.table.border[b] != 0 ? ghost_of<Case>(v, b, a, face) : -1;
                if (ghost < 0) continue;
                const int n = line % stride + line / stride * stride * side + ghost * stride;
                Real* g = quads + (tile * Case::tile_nodes + n) * quad + i % quad;
                const Real value = *g;
                g[quad * in] += Real(2) * value;
                g[quad * 2 * in] -= value;
                *g = Real(0);
            }
            __syncthreads();
        }
}

/// Shared memory to fold `Parts` parts in.
template <class Case, int Parts>
inline constexpr int fold_bytes = (Case::width == 2 || Case::folds_weights
                                       ? 0
                                       : Parts * Case::blocks * Case::tile_nodes * quad *
                                             int(sizeof(typename Case::Real)));

/// Stores quad i of a part of the thread block's tiles.
template <class Case>
__device__ __forceinline__ void store_node(const View<typename Case::Real, Case::dim>& v, const int* block, int part,
                                           int i, const Row<typename Case::Real>& q) {
    const int b = block[i / Case::tile_nodes];
    if (b < 0) return;
    const std::size_t node = std::size_t(v.grid.tile_of[b]) * Case::tile_nodes + i % Case::tile_nodes;
    store_quad(v.grid.tiles + node * node_reals + part * quad, q);
}

/// Parts First, ... of the tiles from their planes; called by all threads, after a barrier. block: -1 where the thread
/// block has none; border: one of them has. spare: fold_bytes.
template <class Case, int First, int Parts>
__device__ __forceinline__ void write_tiles(const View<typename Case::Real, Case::dim>& v, const int* block,
                                            bool border, const typename Case::Real* planes,
                                            typename Case::Real* spare) {
    using P = Planes<Case>;
    constexpr int nodes = Case::tile_nodes, all = Case::blocks * nodes;
#pragma unroll 1
    for (int i = int(thread_now()); i < all; i += Case::threads)
#pragma unroll
        for (int p = 0; p < Parts; ++p) {
            const auto q = sum_planes<Case>(planes + p * P::part + i / nodes * P::block, i % nodes);
            if (border)
                store_quad(spare + (p * all + i) * quad, q);
            else
                store_node<Case>(v, block, First + p, i, q);
        }
    if (!border) return;
    __syncthreads();
    fold_tiles<Case, Parts>(v, block, spare);
#pragma unroll 1
    for (int i = int(thread_now()); i < all; i += Case::threads)
#pragma unroll
        for (int p = 0; p < Parts; ++p)
            store_node<Case>(v, block, First + p, i, load_quad(spare + (p * all + i) * quad));
}

}  // namespace moraine::gpu
