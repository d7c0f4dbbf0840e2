#pragma once
// Who came from other blocks: into the region's tail and into the tile, in the order (source block, slot). A thread
// block per target, a thread per node of its tile: a node asks each particle in turn whether it is in its stencil.

#include "device_lab/fused_layout.cuh"

namespace moraine::gpu::lab {

inline constexpr int incoming_threads = 224;  // at least the nodes of a tile
inline constexpr unsigned incoming_batch = 56;

/// Weight of the node k above the lowest of the stencil, and its slope [1/cell].
template <class Real>
__device__ __forceinline__ void spline_of(unsigned k, Real f, Real& w, Real& d) {
    const Real t = f - (Real(1) - Real(0.5) * Real(k)), a = k == 1 ? Real(-1) : Real(0.5);
    w = a * t * t + (k == 1 ? Real(0.75) : Real(0));
    d = (a + a) * t;
}

/// One node's sums.
template <class Real>
struct NodeSums {
    Real m = 0, q[3] = {0, 0, 0}, f[3] = {0, 0, 0};
    bool touched = false;

    __device__ __forceinline__ void add(const Row<Real>* row, const int (&node)[3], Real inverse_cell) {
        CoreRows<Real, 3> p;
        p.row[p.place] = row[p.place];
        unsigned k[3];
#pragma unroll
        for (int a = 0; a < 3; ++a) k[a] = unsigned(node[a] - moraine::cell_of<Real>(p.coordinate(a)));
        if (k[0] > 2 || k[1] > 2 || k[2] > 2) return;
        touched = true;
        Real w[3], d[3];
#pragma unroll
        for (int a = 0; a < 3; ++a) spline_of(k[a], fraction_of<Real>(p.coordinate(a)), w[a], d[a]);
#pragma unroll
        for (int r = 1; r < core_rows<3>; ++r) p.row[r] = row[r];
        const Real mass = w[0] * w[1] * w[2] * p.mass(), scale = -p.volume() * inverse_cell;
        const Real g[3] = {d[0] * w[1] * w[2] * scale, w[0] * d[1] * w[2] * scale, w[0] * w[1] * d[2] * scale};
        m += mass;
#pragma unroll
        for (int c = 0; c < 3; ++c) {
            q[c] += mass * p.velocity(c);
#pragma unroll
            for (int b = 0; b < 3; ++b) f[c] += p.stress(Sym<Real, 3>::index(c, b)) * g[b];
        }
    }
    __device__ __forceinline__ void add_to(Row<Real>* tile) const {
        Row<Real> first = load_row(tile), second = load_row(tile + 1);
        first.e[0] += m;
#pragma unroll
        for (int c = 0; c < 3; ++c) first.e[1 + c] += q[c], second.e[c] += f[c];
        store_row(tile, first), store_row(tile + 1, second);
    }
};

/// Who comes to a block: by neighbour code, added up, and where they stand.
struct Incoming {
    std::uint32_t upto[32];
    std::size_t from[32];

    /// By the first warp.
    template <class Real>
    __device__ __forceinline__ void find(const FusedStep<Real>& s, int b) {
        const int code = lane_id();
        std::uint32_t n = 0;
        std::size_t at = 0;
        const int source = code < Block<3>::offsets && code != Block<3>::centre
                               ? s.v.table.neighbour[std::size_t(b) * Block<3>::offsets + std::size_t(code)]
                               : -1;
        if (source >= 0 && s.region[source].leaving > 0) {
            const std::uint16_t* exit =
                s.exit_at + std::size_t(source) * (exits + 1) + std::size_t(Block<3>::opposite(code));
            n = exit[1] - exit[0];
            at = std::size_t(source) * s.capacity + exit[0];
        }
        upto[code] = scan_inclusive(n);
        from[code] = at - (upto[code] - n);
    }
    __device__ __forceinline__ std::size_t place(std::uint32_t k) const {
        int code = 0;
#pragma unroll
        for (int step = 16; step > 0; step /= 2)
            if (upto[code + step - 1] <= k) code += step;
        return from[code] + k;
    }
};

/// The last thread block to end makes ready for the next step.
template <class Real>
__device__ __forceinline__ void conclude(const FusedStep<Real>& s) {
    if (atomicAdd(s.ticket, 1u) + 1 < gridDim.x) return;
    *s.ticket = *s.targets = 0;
    *s.overfulls_all += *s.overfulls;
    *s.overfulls = 0;
    ++*s.number;
}

template <class Real>
__global__ void __launch_bounds__(incoming_threads) add_incoming(const __grid_constant__ FusedStep<Real> s) {
    constexpr int side = tile_side(3);
    __shared__ Incoming in;
    __shared__ Row<Real> row[incoming_batch][core_rows<3>];
    const int t = int(threadIdx.x);
    const int node[3] = {t % side, t / side % side, t / (side * side)};
    let_next_launch_begin();
    wait_for_launch_before();
    const std::uint32_t targets = *s.targets;
    for (std::uint32_t item = blockIdx.x; item < targets; item += gridDim.x) {
        const int b = s.target[item];
        __syncthreads();
        if (t < 32) in.find(s, b);
        __syncthreads();
        const std::uint32_t all = in.upto[31], tail = s.region[b].tail;
        const std::size_t to = std::size_t(b) * s.capacity + tail;
        if (tail + all > s.capacity) {
            if (t == 0) *s.error = 1;
            continue;
        }
        NodeSums<Real> sums;
        for (std::uint32_t first = 0; first < all; first += incoming_batch) {
            const unsigned here = min(all - first, incoming_batch);
            if (first > 0) __syncthreads();
            for (unsigned x = unsigned(t); x < here * core_rows<3>; x += incoming_threads) {
                const unsigned k = x / core_rows<3>, r = x % core_rows<3>;
                const std::size_t from = in.place(first + k);
                row[k][r] = load_row(s.v.p.core[r] + from);
                store_row(s.v.p.core[r] + to + first + k, row[k][r]);
                if (r == 0) s.home[to + first + k] = s.home[from];
            }
            __syncthreads();
            if (t < power<3>(side))
                for (unsigned k = 0; k < here; ++k) sums.add(row[k], node, s.v.context.inverse_cell);
        }
        if (sums.touched)
            sums.add_to(reinterpret_cast<Row<Real>*>(s.v.grid.tiles) + (std::size_t(b) * power<3>(side) + t) * 2);
        if (t == 0) {
            s.region[b].incoming = all;
            if (s.tile_of[b] < 0) s.tile_of[b] = b, s.occupied[atomicAdd(s.occupieds, 1u)] = b;
        }
    }
    if (t == 0) conclude(s);
}

}  // namespace moraine::gpu::lab
