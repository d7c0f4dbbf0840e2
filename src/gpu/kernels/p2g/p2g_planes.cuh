#pragma once
// From the sums of cells to the tile of a block, in shared memory and a fixed order, without atomics.
//
// A part is one quad of each node: (mass, momentum) or (force, 0), with the mean in the last lane where it is wanted.
// It has a plane of nodes (2-D: a line) for each slice k and each layer of cells across the last axis. No two warps
// share a plane, and at one node of the slice all cells of a warp write different nodes. A node of the tile is the sum
// of its planes in the order of k.

#include "gpu/kernels/p2g/p2g_slice.cuh"

namespace moraine::gpu {

template <class Case>
struct Planes {
    using Real = typename Case::Real;
    /// Reals of a line, such that the 16 bytes of eight lanes, four cells of two lines, lie in different banks.
    static constexpr int line = sizeof(Real) == 4 ? 48 : 4 * Case::side + 2;
    static constexpr int plane = Case::dim == 3 ? Case::side * line : line;
    static constexpr int block = 4 * Case::width * plane;
    static constexpr int part = Case::blocks * block;
    static constexpr int bytes = part * int(sizeof(Real));

    /// Where the first node of slice k of a cell lies.
    static __device__ __forceinline__ int first(int cell, int k) {
        const int x = cell & 3, y = (cell >> 2) & 3, z = cell >> 4;
        if (Case::dim == 3) return (4 * k + z) * plane + y * line + x * quad;
        return z * block + (4 * k + y) * plane + x * quad;
    }
};

/// A quad by 16-byte accesses: doubles of the planes are aligned to 16 bytes only.
template <class Real>
__device__ __forceinline__ Row<Real> load_quad(const Real* from) {
    Row<Real> q;
#pragma unroll
    for (int i = 0; i < int(sizeof(Real)) / 4; ++i)
        reinterpret_cast<uint4*>(&q)[i] = reinterpret_cast<const uint4*>(from)[i];
    return q;
}
template <class Real>
__device__ __forceinline__ void store_quad(Real* to, const Row<Real>& q) {
#pragma unroll
    for (int i = 0; i < int(sizeof(Real)) / 4; ++i)
        reinterpret_cast<uint4*>(to)[i] = reinterpret_cast<const uint4*>(&q)[i];
}

/// Adds the first `Lanes` numbers of a quad.
template <int Lanes, class Real>
__device__ __forceinline__ void add_quad(Real* to, bool fresh, Row<Real> q) {
    if (!fresh) {
        const Row<Real> old = load_quad(to);
#pragma unroll
        for (int i = 0; i < Lanes; ++i) q.e[i] = old.e[i] + q.e[i];
    }
    store_quad(to, q);
}

/// Adds this thread's sums to its planes, part by part; called by all lanes of a warp.
template <class Case, bool Momentum, bool Force>
__device__ __forceinline__ void add_to_planes(const SliceSums<Case>& s, int k, int cell, typename Case::Real* planes) {
    using Real = typename Case::Real;
    using P = Planes<Case>;
    constexpr int last = Case::dim - 1;
    const int x = cell & 3, y = (cell >> 2) & 3;
    Real* at = planes + P::first(cell, k);
#pragma unroll
    for (int n = 0; n < Case::nodes; ++n) {
        const int i = n % Case::width, j = n / Case::width;
        // Cells come by i, then by j: is this the first to write the node?
        const bool fresh = (i == 0 || x == 3) && (j == 0 || y == 3);
        Real* to = at + P::line * j + quad * i;
        if (Momentum)
            add_quad<1 + Case::dim>(to, fresh,
                                    Row<Real>{s.mass[n], s.momentum[0][n], s.momentum[1][n],
                                              Case::dim == 3 ? s.momentum[last][n] : Real(0)});
        if (Force)
            add_quad<(Case::mean ? quad : Case::dim)>(
                to + (Momentum ? P::part : 0), fresh,
                Row<Real>{s.force[0][n], s.force[1][n], Case::dim == 3 ? s.force[last][n] : Real(0),
                          Case::mean ? s.mean[n % (Case::mean ? Case::nodes : 1)] : Real(0)});
        __syncwarp();
    }
}

/// One quad of node n of a tile; planes: those of its block.
template <class Case>
__device__ __forceinline__ Row<typename Case::Real> sum_planes(const typename Case::Real* planes, int n) {
    using P = Planes<Case>;
    constexpr int side = Case::side;
    const int x = n % side, rest = n / side;
    const int y = Case::dim == 3 ? rest % side : 0, last = Case::dim == 3 ? rest / side : rest;
    const typename Case::Real* at = planes + last * P::plane + y * P::line + x * quad;
    Row<typename Case::Real> sum{};
#pragma unroll
    for (int k = 0; k < Case::width; ++k) {
        const int layer = last - k;
        if (layer < 0 || layer > 3) continue;
        const auto q = load_quad(at + 3 * k * P::plane);
#pragma unroll
        for (int i = 0; i < 4; ++i) sum.e[i] += q.e[i];
    }
    return sum;
}

}  // namespace moraine::gpu
