#pragma once
// Particle to grid, the ways that lost (results.md says by how much and why). None folds ghost nodes.
//
//   gather_nodes    the method paper's: one thread per node goes through the particles of its 27 cells
//   global_atomics  one thread per particle, 189 atomic adds to the nodes
//   shared_atomics  the same into a tile in shared memory
//   warp_reduction  particles of a cell are summed by shuffles first, one lane adds for all
//   fixed_point     integer atomics in shared memory: exact, whatever the order

#include "slice.cuh"

namespace lab {

/// What a variant needs besides the view.
template <class Real>
struct Extra {
    Real* sums;       ///< node blocks x 64 x 8, cleared: for variants without tiles
    double scale[3];  ///< of integers: mass, momentum, force
};

/// Calls f(node of the stencil i j k, quantity, value) 189 times.
template <class Real, class F>
__device__ __forceinline__ void each_value(const View<Real>& v, const Place<Real>& x, const Row<Real>& u,
                                           const Row<Real>& n, const Row<Real>& t, const F& f) {
    Real w[3][3], d[3][3];
    for (int a = 0; a < 3; ++a) Quadratic::weights(fraction_of<Real>(x.u[a]), Real(0), w[a], d[a]);
    const Real scale = -u.w * v.inverse_cell;
#pragma unroll 1
    for (int k = 0; k < 3; ++k)
#pragma unroll 1
        for (int j = 0; j < 3; ++j)
#pragma unroll
            for (int i = 0; i < 3; ++i) {
                Real wy, dy, wz, dz;
                weight_of(j, fraction_of<Real>(x.u[1]), wy, dy);
                weight_of(k, fraction_of<Real>(x.u[2]), wz, dz);
                const Real wm = w[0][i] * wy * wz * x.mass;
                const Real gx = scale * d[0][i] * wy * wz, gy = scale * w[0][i] * dy * wz,
                           gz = scale * w[0][i] * wy * dz;
                f(i, j, k, 0, wm);
                for (int q = 0; q < 3; ++q) f(i, j, k, 1 + q, wm * u.e[q]);
                f(i, j, k, 4, gx * n.e[0] + gy * t.e[0] + gz * t.e[2]);
                f(i, j, k, 5, gx * t.e[0] + gy * n.e[1] + gz * t.e[1]);
                f(i, j, k, 6, gx * t.e[2] + gy * t.e[1] + gz * n.e[2]);
            }
}

template <class Real>
__device__ __forceinline__ int tile_base(const Place<Real>& x) {
    return cell_of<Real>(x.u[0]) + side * (cell_of<Real>(x.u[1]) + side * cell_of<Real>(x.u[2]));
}

template <class Real>
__global__ void __launch_bounds__(256) gather_nodes(const __grid_constant__ View<Real> v, Extra<Real> extra) {
    const int c = int(blockIdx.x) * 4 + int(threadIdx.x) / 64, n = int(threadIdx.x) & 63;
    if (c >= v.node_blocks) return;
    Real sum[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    for (int o = 0; o < 27; ++o) {
        const int off[3] = {o % 3, o / 3 % 3, o / 9};
        int delta = 0, cell = 0;
        for (int a = 2; a >= 0; --a) {
            const int at = ((n >> (2 * a)) & 3) - off[a];
            delta = 2 * delta + (at < 0);
            cell = 4 * cell + (at & 3);
        }
        const int b = v.source[c * 8 + delta];
        if (b < 0) continue;
        const std::uint32_t* at = v.cell_first + std::size_t(b) * bounds + cell;
        for (std::uint32_t k = at[0]; k < at[1]; ++k) {
            const std::uint32_t s = v.slot[v.first[b] + k];
            const Place<Real> x = load_row(v.p.place + s);
            const Row<Real> u = load_row(v.p.motion + s), nn = load_row(v.p.normal + s), t = load_row(v.p.shear + s);
            Real w[3], d[3];
            for (int a = 0; a < 3; ++a) weight_of(off[a], fraction_of<Real>(x.u[a]), w[a], d[a]);
            const Real wm = w[0] * w[1] * w[2] * x.mass, scale = -u.w * v.inverse_cell;
            const Real gx = scale * d[0] * w[1] * w[2], gy = scale * w[0] * d[1] * w[2],
                       gz = scale * w[0] * w[1] * d[2];
            sum[0] += wm;
            for (int q = 0; q < 3; ++q) sum[1 + q] += wm * u.e[q];
            sum[4] += gx * nn.e[0] + gy * t.e[0] + gz * t.e[2];
            sum[5] += gx * t.e[0] + gy * nn.e[1] + gz * t.e[1];
            sum[6] += gx * t.e[2] + gy * t.e[1] + gz * nn.e[2];
        }
    }
    Real* to = extra.sums + (std::size_t(c) * cells + n) * 8;
    for (int q = 0; q < 8; ++q) to[q] = sum[q];
}

template <class Real>
__global__ void __launch_bounds__(128) global_atomics(const __grid_constant__ View<Real> v, Extra<Real> extra) {
    const int b = v.chosen();
    for (std::uint32_t k = v.first[b] + threadIdx.x; k < v.first[b + 1]; k += 128) {
        const std::uint32_t s = v.slot[k];
        const Place<Real> x = load_row(v.p.place + s);
        each_value(v, x, load_row(v.p.motion + s), load_row(v.p.normal + s), load_row(v.p.shear + s),
                   [&](int i, int j, int k2, int q, Real value) {
                       const int o[3] = {i, j, k2};
                       int corner = 0, at = 0;
                       for (int a = 2; a >= 0; --a) {
                           const int n = cell_of<Real>(x.u[a]) + o[a];
                           corner = 2 * corner + (n >> 2);
                           at = 4 * at + (n & 3);
                       }
                       atomicAdd(extra.sums + (std::size_t(v.node_block[b * 8 + corner]) * cells + at) * 8 + q, value);
                   });
    }
}

/// The three variants that sum a tile in shared memory; Way: 0 atomics, 1 warp reduction, 2 integers.
template <class Real, int Way>
__global__ void __launch_bounds__(128) shared_tile(const __grid_constant__ View<Real> v, Extra<Real> extra) {
    using Whole = std::conditional_t<sizeof(Real) == 4, int, unsigned long long>;
    using Cell = std::conditional_t<Way == 2, Whole, Real>;
    __shared__ Cell T[7 * tile_nodes];
    const int b = v.chosen();
    const std::uint32_t begin = v.first[b], end = v.first[b + 1];
    if (begin == end) return;
    for (int n = int(threadIdx.x); n < 7 * tile_nodes; n += 128) T[n] = Cell(0);
    __syncthreads();
    for (std::uint32_t k0 = begin; k0 < end; k0 += 128) {
        const std::uint32_t k = k0 + threadIdx.x;
        if (Way != 1 && k >= end) continue;
        const bool in = k < end;
        const std::uint32_t s = v.slot[in ? k : end - 1];
        const Place<Real> x = load_row(v.p.place + s);
        const int base = tile_base(x);
        const unsigned peers = Way == 1 ? __match_any_sync(0xffffffffu, in ? base : -1) : 0;
        const int lane = int(threadIdx.x) & 31;
        const int last = 31 - __clz(peers);
        const bool head = Way != 1 || (in && __ffs(peers) - 1 == lane);
        each_value(v, x, load_row(v.p.motion + s), load_row(v.p.normal + s), load_row(v.p.shear + s),
                   [&](int i, int j, int k2, int q, Real value) {
                       Cell* to = T + q * tile_nodes + base + i + side * (j + side * k2);
                       if (Way == 1) {
                           for (int d = 1; d < 32; d *= 2) {
                               const Real other = __shfl_down_sync(0xffffffffu, value, d);
                               if (lane + d <= last) value += other;
                           }
                       }
                       if constexpr (Way == 2) {
                           const double whole = double(value) * extra.scale[(q + 2) / 3];
                           atomicAdd(to, static_cast<Whole>(__double2ll_rn(whole)));
                       } else {
                           if (head) atomicAdd(to, value);
                       }
                   });
    }
    __syncthreads();
    Real* tile = reinterpret_cast<Real*>(v.tiles) + std::size_t(b) * tile_nodes * 8;
    for (int n = int(threadIdx.x); n < tile_nodes; n += 128) {
        for (int q = 0; q < 7; ++q) {
            if constexpr (Way == 2)
                tile[n * 8 + q] = Real(double((long long)(T[q * tile_nodes + n])) / extra.scale[(q + 2) / 3]);
            else
                tile[n * 8 + q] = T[q * tile_nodes + n];
        }
        tile[n * 8 + 7] = Real(0);
    }
}

}  // namespace lab
