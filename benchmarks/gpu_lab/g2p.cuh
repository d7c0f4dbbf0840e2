#pragma once
// Grid to particles with the stress update: one thread per particle.
//
// g2p reads a particle's rows when it needs them; g2p_ahead has the next particle's rows on their way into the
// thread's own shared memory (cp.async, no barrier) while it works on this one.

#include "copy_async.cuh"
#include "gather.cuh"

namespace lab {

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
        if (!(size < Real(1)))
            out.faults |= size >= Real(1) ? fault_far : fault_nan, step = Real(0);
        else
            out.moved = float(size) > out.moved ? float(size) : out.moved;
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

/// The same, the next particle's rows on their way into this thread's own shared memory meanwhile (cp.async, no
/// barrier): the latency of memory is hidden, and rows take registers only where they are used.
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
        const uint4* rows[4] = {
            reinterpret_cast<const uint4*>(v.p.place + s), reinterpret_cast<const uint4*>(v.p.motion + s),
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
