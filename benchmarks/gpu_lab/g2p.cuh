#pragma once
// Grid to particles with the stress update: one thread per particle, 216 nodes in shared memory.
//
// Sums are nested: along a line x, then y, then z; 9 + 4 + 5/3 products of three per node instead of 18. The cell is
// the top bits of the place, so no cell list is read. Ghost nodes behind walls are set once per tile by linear
// extrapolation, v_-1 = 2 v_0 - v_1: the same as folding each particle's weights, and no particle asks for walls.
// Narrow: v and dv of a node as a quad and a pair (6 reals) instead of two quads.

#include "copy_async.cuh"
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
            if (!v.walls.fold[a][s] || ghost < 0 || ghost >= side || ghost + 2 * in < 0 || ghost + 2 * in >= side) continue;
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
__device__ __forceinline__ void line_of(const NodeTile<Real, Narrow>& tile, int at, const Real (&w)[3], const Real (&dw)[3],
                                        Real (&lv)[3], Real (&ld)[3], Real (&lx)[3]) {
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
__device__ __forceinline__ void line_of(const DifferenceTile<Real>& tile, int at, const Real (&w)[3], const Real (&dw)[3],
                                        Real (&lv)[3], Real (&ld)[3], Real (&lx)[3]) {
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

/// Stress, volume and history of one particle; what the step control must know. As update_point of src/core/stress.hpp,
/// with the particle in registers.
template <class Real>
__device__ __forceinline__ void update_stress(const View<Real>& v, const Gathered<Real>& g, Real dt, Real mass,
                                              Row<Real>& motion, Row<Real>& normal, Row<Real>& shear, Outcome& out) {
    using std::exp;
    Mat<Real, 3> dL;
    const Real scale = dt * v.inverse_cell;
#pragma unroll
    for (int a = 0; a < 3; ++a)
#pragma unroll
        for (int b = 0; b < 3; ++b) dL(a, b) = scale * g.gradient[b][a];
    PointState<Real, 3> state;
    for (int q = 0; q < 3; ++q) state.stress[q] = normal.e[q], state.stress[3 + q] = shear.e[q];
    state.history[0] = shear.w;
    const Sym<Real, 3> before = state.stress;
    const StrainIncrement<Real, 3> step = strain_increment(dL, dt);
    state.ln_J = normal.w + step.volumetric;
    v.law.update(step, state);
    const Real J = exp(state.ln_J);
    const Real volume = mass * v.inverse_density * J;
    for (int q = 0; q < 3; ++q) normal.e[q] = state.stress[q], shear.e[q] = state.stress[3 + q];
    normal.w = state.ln_J, shear.w = state.history[0], motion.w = volume;
    Sym<Real, 3> both;
    Real any = motion.e[0] * motion.e[0] + motion.e[1] * motion.e[1] + motion.e[2] * motion.e[2];
    const float square = float(any), modulus = float(v.law.wave_modulus(state) * J);
    for (int q = 0; q < 6; ++q) both[q] = before[q] + state.stress[q];
    const Real power = volume * contract(both, step.middle);
    out.work += 0.5 * double(power);
    out.speed2 = square > out.speed2 ? square : out.speed2;
    out.modulus = modulus > out.modulus ? modulus : out.modulus;
    any = any * Real(0) + power * Real(0) + step.stretch * Real(0);  // 0 unless one of them is not finite
    for (int q = 0; q < 6; ++q) any = fma(state.stress[q], Real(0), any);
    if (!(any == Real(0))) out.faults |= fault_nan;
    if (step.stretch <= Real(0)) out.faults |= fault_inverted;
}

template <class Real>
__device__ __forceinline__ int cell_at(const Place<Real>& x) {
    return cell_of<Real>(x.u[0]) + 4 * cell_of<Real>(x.u[1]) + 16 * cell_of<Real>(x.u[2]);
}

/// New place; returns the move (src/core/g2p.hpp). Domain ends are walls here, not exits.
template <class Real>
__device__ __forceinline__ std::uint16_t advance_place(const View<Real>& v, const Real (&velocity)[3], Real dt,
                                                       Place<Real>& x, Outcome& out) {
    int code = 0, cell = 0;
#pragma unroll
    for (int a = 2; a >= 0; --a) {
        Real step = dt * velocity[a] * v.inverse_cell;
        const Real size = step < Real(0) ? -step : step;
        if (!(size < Real(1))) out.faults |= size >= Real(1) ? fault_far : fault_nan, step = Real(0);
        else out.moved = float(size) > out.moved ? float(size) : out.moved;
        code = 3 * code + advance<Real>(x.u[a], step) + 1;
        cell = 4 * cell + cell_of<Real>(x.u[a]);
    }
    return std::uint16_t(code * 64 + cell);
}

/// Block-wide outcome in a fixed order.
template <int Threads>
__device__ __forceinline__ void store_outcome(Outcome out, Outcome* to) {
    __shared__ Outcome warp_out[Threads / 32];
#pragma unroll
    for (int d = 16; d > 0; d /= 2) {
        out.work += __shfl_down_sync(0xffffffffu, out.work, d);
        out.speed2 = fmaxf(out.speed2, __shfl_down_sync(0xffffffffu, out.speed2, d));
        out.modulus = fmaxf(out.modulus, __shfl_down_sync(0xffffffffu, out.modulus, d));
        out.moved = fmaxf(out.moved, __shfl_down_sync(0xffffffffu, out.moved, d));
    }
    out.faults = __reduce_or_sync(0xffffffffu, out.faults);
    if (threadIdx.x % 32 == 0) warp_out[threadIdx.x / 32] = out;
    __syncthreads();
    if (threadIdx.x != 0) return;
    for (int w = 1; w < Threads / 32; ++w) {
        out.work += warp_out[w].work;
        out.speed2 = fmaxf(out.speed2, warp_out[w].speed2);
        out.modulus = fmaxf(out.modulus, warp_out[w].modulus);
        out.moved = fmaxf(out.moved, warp_out[w].moved);
        out.faults |= warp_out[w].faults;
    }
    *to = out;
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

/// The part of the step that needs the particle's own rows.
template <class Real>
__device__ __forceinline__ void take_velocity(const View<Real>& v, const Gathered<Real>& g, Row<Real>& motion) {
#pragma unroll
    for (int q = 0; q < 3; ++q) {
        const Real full = motion.e[q] + g.change[q];
        motion.e[q] = fma(v.flip, full - g.velocity[q], g.velocity[q]);
    }
}

template <class Real, int Threads, int MinBlocks, bool Narrow>
__global__ void __launch_bounds__(Threads, MinBlocks) g2p(const __grid_constant__ View<Real> v) {
    __shared__ NodeTile<Real, Narrow> tile;
    const int b = v.chosen();
    const std::uint32_t begin = v.first[b], end = v.first[b + 1];
    Outcome out{0, 0, 0, 0, 0};
    if (begin == end) {
        if (threadIdx.x == 0) v.outcome[b] = out;
        return;
    }
    load_tile(v, b, tile);
    const Real dt = Real(*v.dt);
#pragma unroll 1
    for (std::uint32_t k = begin + threadIdx.x; k < end; k += Threads) {
        const std::uint32_t s = v.slot[k];
        Place<Real> x = load_row(v.p.place + s);
        Row<Real> motion = load_row(v.p.motion + s), normal = load_row(v.p.normal + s), shear = load_row(v.p.shear + s);
        const Gathered<Real> g = gather<Real>(tile, x);
        take_velocity(v, g, motion);
        const int from = cell_at(x);
        const std::uint16_t move = advance_place(v, g.velocity, dt, x, out);
        v.moves[k] = move;
        note_changed(v, b, begin, end, k, move != Block<3>::centre * 64 + from);
        store_row(v.p.place + s, x);
        update_stress(v, g, dt, x.mass, motion, normal, shear, out);
        store_row(v.p.motion + s, motion);
        store_row(v.p.normal + s, normal);
        store_row(v.p.shear + s, shear);
    }
    store_outcome<Threads>(out, v.outcome + b);
}

/// The same, the next particle's rows on their way into this thread's own shared memory meanwhile (cp.async, no barrier):
/// the latency of memory is hidden, and rows take registers only where they are used.
template <class Real, int Threads, int MinBlocks, bool Difference>
__global__ void __launch_bounds__(Threads, MinBlocks) g2p_ahead(const __grid_constant__ View<Real> v) {
    constexpr int per_row = int(sizeof(Real)) / 4, units = 4 * per_row;
    using Tile = std::conditional_t<Difference, DifferenceTile<Real>, NodeTile<Real, true>>;
    __shared__ Tile tile;
    extern __shared__ uint4 ahead[];  // [2][units][Threads]
    const int b = v.chosen();
    const std::uint32_t begin = v.first[b], end = v.first[b + 1];
    Outcome out{0, 0, 0, 0, 0};
    if (begin == end) {
        if (threadIdx.x == 0) v.outcome[b] = out;
        return;
    }
    const auto start = [&](std::uint32_t s, int half) {
        const uint4* rows[4] = {reinterpret_cast<const uint4*>(v.p.place + s), reinterpret_cast<const uint4*>(v.p.motion + s),
                                reinterpret_cast<const uint4*>(v.p.normal + s), reinterpret_cast<const uint4*>(v.p.shear + s)};
        uint4* to = ahead + half * units * Threads + threadIdx.x;
#pragma unroll
        for (int u = 0; u < units; ++u) copy_async(to + u * Threads, rows[u / per_row] + u % per_row);
    };
    std::uint32_t k = begin + threadIdx.x;
    std::uint32_t s = k < end ? v.slot[k] : 0, next = k + Threads < end ? v.slot[k + Threads] : 0;
    if (k < end) start(s, 0);
    commit_async();
    if (threadIdx.x == 0 && v.ahead > 0) prefetch_block(v, int(blockIdx.x) + v.ahead);
    if constexpr (Difference) {
        load_tile(v, b, tile.node);
        take_steps(tile);
    } else {
        load_tile(v, b, tile);
    }
    const Real dt = Real(*v.dt);
    int half = 0;
#pragma unroll 1
    for (; k < end; k += Threads) {
        if (k + Threads < end) start(next, half ^ 1);
        commit_async();
        const std::uint32_t after = k + 2 * Threads < end ? v.slot[k + 2 * Threads] : 0;
        wait_async<1>();
        const uint4* mine = ahead + half * units * Threads + threadIdx.x;
        const auto row = [&](auto& to, int r) {
#pragma unroll
            for (int u = 0; u < per_row; ++u) reinterpret_cast<uint4*>(&to)[u] = mine[(r * per_row + u) * Threads];
        };
        Place<Real> x;
        row(x, 0);
        const Gathered<Real> g = gather<Real>(tile, x);
        const int from = cell_at(x);
        const std::uint16_t move = advance_place(v, g.velocity, dt, x, out);
        v.moves[k] = move;
        note_changed(v, b, begin, end, k, move != Block<3>::centre * 64 + from);
        store_row(v.p.place + s, x);
        Row<Real> motion, normal, shear;
        row(motion, 1);
        take_velocity(v, g, motion);
        row(normal, 2), row(shear, 3);
        update_stress(v, g, dt, x.mass, motion, normal, shear, out);
        store_row(v.p.motion + s, motion);
        store_row(v.p.normal + s, normal);
        store_row(v.p.shear + s, shear);
        s = next, next = after, half ^= 1;
    }
    store_outcome<Threads>(out, v.outcome + b);
}

}  // namespace lab
