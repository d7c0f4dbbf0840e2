#pragma once
// The nodes of one block's particles in shared memory: v' and dv in 2 Dim reals per node, ghosts behind walls set. Who
// takes velocities alone (Change = false) has tiles without dv.
//
// Ghost nodes follow the two nodes before them once per tile, v_-1 = 2 v_0 - v_1 (core/grid/walls.hpp), so no particle
// asks for walls. Places in a tile are 64-bit: NVRTC addresses shared memory so, and widens a 32-bit place for every
// node of a stencil (von Mises, FLIP, 3-D, single: 2770 instructions and 4 bytes spilled, instead of 2748 and none). In
// single precision the tile also holds the steps along x, node[n + 1] - node[n]: weights sum to one and slopes to zero,
// so a line of w nodes takes w - 1 products of each sum instead of w (measured: a tenth fewer instructions; in double
// the shared memory costs more than it saves).

#include "gpu/kernels/copy_async.cuh"
#include "gpu/kernels/team.cuh"

namespace moraine::gpu {

template <class Real, int Dim, bool Change = true>
struct NodeValue {
    Real v[Dim];                ///< v', first quad [m/s]
    Real dv[Change ? Dim : 1];  ///< second quad [m/s]

    /// By component: takes f(of mine, of the other's).
    template <class F>
    __device__ __forceinline__ void combine(const NodeValue& other, const F& f) {
        for (int q = 0; q < Dim; ++q) {
            v[q] = f(v[q], other.v[q]);
            if constexpr (Change) dv[q] = f(dv[q], other.dv[q]);
        }
    }
};

template <class Real, int Dim, int Width, bool Change = true>
struct NodeTile {
    using Value = NodeValue<Real, Dim, Change>;
    static constexpr int side = tile_side(Width), size = power<Dim>(side);
    static constexpr bool has_change = Change;

    struct alignas(2 * sizeof(Real)) Pair {
        Real e[2];
    };
    Row<Real> row[size];                       ///< 3-D: v, dv_x; 2-D: v, dv
    Pair pair[Dim == 3 && Change ? size : 1];  ///< 3-D: dv_y, dv_z

    __device__ __forceinline__ Value get(std::ptrdiff_t n) const {
        const Row<Real> r = load_row(row + n);
        if constexpr (!Change) {
            Value x;
            for (int q = 0; q < Dim; ++q) x.v[q] = r.e[q];
            return x;
        } else if constexpr (Dim == 3) {
            const Pair p = pair[n];
            return {{r.e[0], r.e[1], r.e[2]}, {r.e[3], p.e[0], p.e[1]}};
        } else {
            return {{r.e[0], r.e[1]}, {r.e[2], r.e[3]}};
        }
    }
    __device__ __forceinline__ void set(std::ptrdiff_t n, const Value& x) {
        if constexpr (!Change) {
            store_row(row + n, Row<Real>{{x.v[0], x.v[1], Dim == 3 ? x.v[Dim - 1] : Real(0), Real(0)}});
        } else if constexpr (Dim == 3) {
            store_row(row + n, Row<Real>{{x.v[0], x.v[1], x.v[2], x.dv[0]}});
            pair[n] = {{x.dv[1], x.dv[2]}};
        } else {
            store_row(row + n, Row<Real>{{x.v[0], x.v[1], x.dv[0], x.dv[1]}});
        }
    }
};

/// The same with the steps along x: step.get(n) is node n + 1 less node n.
template <class Real, int Dim, int Width, bool Change = true>
struct StepTile {
    NodeTile<Real, Dim, Width, Change> node, step;
};

/// What a gather uses: steps in single precision.
template <class Real, int Dim, int Width, bool Change = true>
using GatherTile =
    std::conditional_t<sizeof(Real) == 4, StepTile<Real, Dim, Width, Change>, NodeTile<Real, Dim, Width, Change>>;

template <class Real, int Dim, int Width, bool Change>
__device__ __forceinline__ NodeTile<Real, Dim, Width, Change>& nodes_of(NodeTile<Real, Dim, Width, Change>& tile) {
    return tile;
}
template <class Real, int Dim, int Width, bool Change>
__device__ __forceinline__ NodeTile<Real, Dim, Width, Change>& nodes_of(StepTile<Real, Dim, Width, Change>& tile) {
    return tile.node;
}

template <class Real, int Dim, int Width, bool Change>
__device__ __forceinline__ void take_steps(NodeTile<Real, Dim, Width, Change>&) {}

template <class Real, int Dim, int Width, bool Change>
__device__ __forceinline__ void take_steps(StepTile<Real, Dim, Width, Change>& tile) {
    for (std::ptrdiff_t n = Team<Dim>::rank(); n < tile.node.size - 1; n += Team<Dim>::threads) {
        auto step = tile.node.get(n + 1);
        step.combine(tile.node.get(n), [](Real b, Real a) { return b - a; });
        tile.step.set(n, step);
    }
    Team<Dim>::sync();
}

template <int Width, class Real, int Dim, class Tile>
__device__ __forceinline__ void set_ghosts(const View<Real, Dim>& v, int block, int origin, Tile& tile) {
    constexpr int side = tile_side(Width), lines = power<Dim>(side) / side;
    int stride = 1;
    for (int a = 0; a < Dim; ++a, stride *= side)
        for (int s = 0; s < 2; ++s) {
            const int inward = s == 0 ? 1 : -1;
            const int ghost = v.context.walls.plane[a][s] - inward - (4 * v.table.position[block][a] - origin);
            const int second = ghost + 2 * inward;
            if (!v.context.walls.fold[a][s] || ghost < 0 || ghost >= side || second < 0 || second >= side) continue;
            for (int line = Team<Dim>::rank(); line < lines; line += Team<Dim>::threads) {
                const int low = line % stride, at = (line - low) * side + low;
                auto x = tile.get(at + (ghost + inward) * stride);
                x.combine(tile.get(at + second * stride), [](Real near, Real far) { return Real(2) * near - far; });
                tile.set(at + ghost * stride, x);
            }
            Team<Dim>::sync();
        }
}

/// Node n of a block's tile of `Side` nodes per axis, as nodes are stored.
template <int Side, class Real, int Dim>
__device__ __forceinline__ std::size_t stored_in_tile(const View<Real, Dim>& v, int block, int n) {
    int corner = 0, at = 0, rest = n;
#pragma unroll
    for (int a = 0; a < Dim; ++a) {
        const int x = rest % Side;
        rest /= Side;
        corner |= (x >> 2) << a;
        at |= (x & 3) << (2 * a);
    }
    const std::int32_t node_block = v.grid.node_of[v.table.node_block[block * Block<Dim>::corners + corner]];
    return std::size_t(node_block) * Block<Dim>::cells + std::size_t(at);
}

/// Its two rows.
template <int Side, class Real, int Dim>
__device__ __forceinline__ const Row<Real>* node_in_tile(const View<Real, Dim>& v, int block, int n) {
    return reinterpret_cast<const Row<Real>*>(v.grid.nodes) + stored_in_tile<Side>(v, block, n) * 2;
}

/// Fills the tile of a block; all threads of the team, which see it afterwards. Shape says where block 0 starts.
template <class Shape, class Real, int Dim, class Tile>
__device__ __forceinline__ void load_tile(const View<Real, Dim>& v, int block, Tile& tile) {
    constexpr int side = tile_side(Shape::width);
    auto& nodes = nodes_of(tile);
    for (int n = Team<Dim>::rank(); n < power<Dim>(side); n += Team<Dim>::threads) {
        const Row<Real>* from = node_in_tile<side>(v, block, n);
        typename std::decay_t<decltype(nodes)>::Value x;
        const Row<Real> first = load_row(from);
        for (int q = 0; q < Dim; ++q) x.v[q] = first.e[q];
        if constexpr (std::decay_t<decltype(nodes)>::has_change) {
            const Row<Real> second = load_row(from + 1);
            for (int q = 0; q < Dim; ++q) x.dv[q] = second.e[q];
        }
        nodes.set(n, x);
    }
    Team<Dim>::sync();
    if (Shape::width > 2 && v.table.border[block]) set_ghosts<Shape::width>(v, block, Shape::origin, nodes);
    take_steps(tile);
}

}  // namespace moraine::gpu
