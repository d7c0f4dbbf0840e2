#pragma once
// How kernels of surfaces see the nodes of a block's tile and the sums at nodes (gpu/kernels/surfaces/surfaces.hpp).

#include "core/data/quad.hpp"
#include "core/surfaces/element_rule.hpp"
#include "gpu/kernels/account.cuh"
#include "gpu/kernels/surfaces/surface_work.hpp"

namespace moraine::gpu {

inline constexpr int surface_threads = 128;

template <int Dim>
inline constexpr int surface_tile = power<Dim>(tile_side(3));

/// Place of the middle of a cell's stencil behind its first node, in a tile.
template <int Dim>
inline constexpr int to_middle = Dim == 2 ? 1 + tile_side(3) : 1 + tile_side(3) * (1 + tile_side(3));

/// Of the nodes of a block's tile: node block times cells plus node, as nodes are stored; and number among near ones.
template <int Dim>
struct TileNodes {
    std::int32_t place[surface_tile<Dim>];
    std::int32_t stored[surface_tile<Dim>];  ///< the same; -1: it holds no soil
    std::int32_t near[surface_tile<Dim>];

    /// By all threads of the thread block, which wait for each other.
    template <class Real>
    __device__ __forceinline__ void find(const SurfaceWork<Real, Dim>& w, int block) {
        constexpr int side = tile_side(3), cells = Block<Dim>::cells;
        for (int n = static_cast<int>(threadIdx.x); n < surface_tile<Dim>; n += surface_threads) {
            int corner = 0, at = 0;
            for (int a = 0, rest = n; a < Dim; ++a, rest /= side) {
                const int x = rest % side;
                corner |= (x >> 2) << a, at |= (x & 3) << (2 * a);
            }
            const std::int32_t c = w.view.table.node_block[block * Block<Dim>::corners + corner];
            const std::int32_t i = c * cells + at;
            const Real mass = w.view.grid.nodes[std::size_t(i) * node_reals + quad - 1];
            place[n] = i;
            stored[n] = mass > w.mass_cutoff ? i : -1;
            near[n] = w.tables.near_of[c] * cells + at;
        }
        __syncthreads();
    }
    /// Of node n; null: it holds no soil.
    template <class Real>
    __device__ __forceinline__ const Real* values(const SurfaceWork<Real, Dim>& w, int n) const {
        const std::int32_t i = stored[n];
        return i < 0 ? nullptr : w.view.grid.nodes + std::size_t(i) * node_reals;
    }
};

/// A giver.
template <class Real, int Dim>
struct Giver {
    const SurfaceWork<Real, Dim>& w;
    const int g = static_cast<int>(blockIdx.x);
    const SurfaceBed<Dim>& bed = w.tables.bed[w.tables.giver[g]];
    const std::int32_t block = bed.block;

    __device__ __forceinline__ Real* tile() const {
        return w.tiles.tile + std::size_t(w.tables.ghosts + g) * surface_tile<Dim> * node_reals;
    }
    /// The node in the middle of a cell's stencil.
    __device__ __forceinline__ Vec<std::int32_t, Dim> node(int c) const {
        Vec<std::int32_t, Dim> n;
        for (int a = 0; a < Dim; ++a)
            n[a] = first_node<Quadratic>(w.view.table.position[block][a]) + 1 + ((c >> (2 * a)) & 3);
        return n;
    }
    /// Where that is beside a structure [m].
    __device__ __forceinline__ Vec<double, Dim> centre_of(int c, const Structure<Dim>& s) const {
        const Vec<std::int32_t, Dim> n = node(c);
        return node_place(w.field, s, &n[0], 0.0);
    }
    /// By one thread.
    __device__ __forceinline__ void gives(bool any) const { w.tiles.tile_of[block] = any ? w.tables.ghosts + g : -1; }
};

/// Place of node i of a cell in the tile, from the cell's first node on.
template <int Dim>
__device__ __forceinline__ int place_of_node(int i) {
    int at = 0;
    for (int a = 0, stride = 1; a < Dim; ++a, i /= 3, stride *= tile_side(3)) at += i % 3 * stride;
    return at;
}

/// What the nodes of an element hold (core/surfaces/element_rule.hpp), by the lanes of a warp, a node each: sums come
/// to all of them, alike.
template <class Real, int Dim>
struct ElementNodes {
    const SurfaceWork<Real, Dim>& w;
    const TileNodes<Dim>& nodes;
    int corner;

    __device__ __forceinline__ const Real* values(int at) const { return nodes.values(w, corner + at); }
    __device__ __forceinline__ SurfaceShares<Dim> shares(int at) const {
        return shares_of<Dim>(w.shares + std::size_t(nodes.near[corner + at]) * node_reals);
    }
    template <int N, class F>
    __device__ __forceinline__ Vec<double, N> sum(const F& f) const {
        Vec<double, N> all = zero_vec<double, N>();
        const int i = lane_id();
        if (i < power<Dim>(3)) f(i, place_of_node<Dim>(i), all);
#pragma unroll
        for (int way = 16; way > 0; way /= 2)
#pragma unroll
            for (int n = 0; n < N; ++n) all[n] += __shfl_xor_sync(all_lanes, all[n], way);
        return all;
    }
};

/// Which elements of a block the soil touches: a bit each, and whose cells they are.
template <int Dim>
struct TouchedElements {
    static_assert(Block<Dim>::cells <= 64);
    unsigned bits[2];
    std::uint8_t cell[Block<Dim>::cells];

    /// By all threads of the thread block, which wait for each other; touches: element number `thread`, if it is one.
    __device__ __forceinline__ bool find(bool touches, int of_cell) {
        const int k = static_cast<int>(threadIdx.x);
        const unsigned mine = __ballot_sync(all_lanes, touches);
        if (k < 64 && lane_id() == 0) bits[k / 32] = mine;
        if (touches) cell[k] = static_cast<std::uint8_t>(of_cell);
        __syncthreads();
        return (bits[0] | bits[1]) != 0;
    }
    /// By the lanes of a warp, a node each, in the elements' order: sums[lane of the node's sums][node of the tile]
    /// gets what f(element, node of it) says.
    template <class Real, class F>
    __device__ __forceinline__ void add(Real (&sums)[surface_tile<Dim>], const F& f) const {
        const int i = lane_id(), place = place_of_node<Dim>(i);
        each([&](int k) {
            if (i < power<Dim>(3)) sums[tile_offset<Dim, 3>(cell[k]) + place] += f(k, i);
            __syncwarp();
        });
    }
    /// f(number), in their order.
    template <class F>
    __device__ __forceinline__ void each(const F& f) const {
#pragma unroll
        for (int half = 0; half < 2; ++half)
            for (unsigned left = bits[half]; left != 0; left &= left - 1)
                f(32 * half + __ffs(static_cast<int>(left)) - 1);
    }
};

/// +0 plus the tiles of those that give, by offset, as in core/grid/tile_sums.hpp. Returns whether somebody does.
template <int Quads, class Real, int Dim>
__device__ __forceinline__ bool sum_given(const SurfaceWork<Real, Dim>& w, int c, int n, Quad<Real> (&sums)[Quads]) {
    bool known = false;
#pragma unroll
    for (int q = 0; q < Quads; ++q) sums[q] = Quad<Real>::zero();
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const std::int32_t source = w.view.table.source[c * Block<Dim>::corners + delta];
        const std::int32_t tile = source < 0 ? -1 : w.tiles.tile_of[source];
        if (tile < 0) continue;
        known = true;
        const int at = tile_node<Dim>(n, delta, 3);
        if (at < 0) continue;
        const auto* from = reinterpret_cast<const Quad<Real>*>(w.tiles.tile) +
                           (std::size_t(tile) * surface_tile<Dim> + std::size_t(at)) * 2;
#pragma unroll
        for (int q = 0; q < Quads; ++q) sums[q] = sums[q] + from[q];
    }
    return known;
}

/// f(near node block j, node block c, node n) of all nodes near surfaces, in whole warps; j < 0: none is left.
template <class Real, int Dim, class F>
__device__ __forceinline__ void each_near_node(const SurfaceWork<Real, Dim>& w, const F& f) {
    constexpr int cells = Block<Dim>::cells, blocks = surface_threads / cells;
    const int j = static_cast<int>(blockIdx.x) * blocks + static_cast<int>(threadIdx.x) / cells;
    const int n = static_cast<int>(threadIdx.x) % cells;
    const bool there = j < w.tables.near;
    f(there ? j : -1, there ? w.tables.near_nodes[j] : -1, n);
}

/// Writes one real of each lane of the first `Quads` quads of a node of a tile.
template <class Real>
__device__ __forceinline__ void store_quads(Real* to, const Quad<Real>& first, const Quad<Real>& second) {
    store_row(reinterpret_cast<Quad<Real>*>(to), first);
    store_row(reinterpret_cast<Quad<Real>*>(to) + 1, second);
}

}  // namespace moraine::gpu
