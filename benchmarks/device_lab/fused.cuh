#pragma once
// The fused step: gather with stress, binning and the next particle to grid of one block, in one thread block.
//
// Ahead: see fused_step.
//
//   1 gather   one thread per particle; rows are copied to shared memory at once, updated there, and keyed
//   2 sort     stable, by cell, then by exit of those who leave: counts of chunks of 32, added up
//   3 write    rows in the new order into the block's region
//   4 P2G      one thread per (cell, slice), as in the program, with rows from shared memory in the new order;
//              tile of those who stay. Passes: 1, or momentum, then force
//
// Who leaves is added to tiles by add_incoming.cuh. A block with more particles than fit goes on a list, which an
// instance with all of a multiprocessor's shared memory works off.

#include "device_lab/fused_copies.cuh"
#include "device_lab/fused_order.cuh"

namespace moraine::gpu::lab {

template <class Real, class Law, int Capacity, int Passes, bool Ahead>
struct Fused {
    using Case = P2gCase<Real, 3, Quadratic, false>;
    using H = Held<Real, Capacity, Passes, Ahead>;
    using F = FusedGather<Real, 3, Quadratic, Law, false, false, false, FluidGrid::none>;
    using Core = CoreRows<Real, 3>;
    using Step = FusedStep<Real>;
    using Copies = FusedCopies<Real, Capacity, Passes, Ahead>;
    using Order = FusedOrder<Real, Capacity, Passes, Ahead>;
    static constexpr unsigned threads = H::threads;

    /// One particle, as FusedGather::update; returns its key.
    static __device__ __forceinline__ int update(const Step& s, const Law& law, Real inverse_density, int b, unsigned i,
                                                 H& held, Seen<Real>& tally, double& power) {
        const View<Real, 3>& v = s.v;
        const unsigned at = H::at(i);
        Core p;
        p.row[p.place] = held.take(at, p.place);
        auto u = place_of<Real, 3>(p);
        const auto sums = F::sums_of(v, s.g, b, u, held.nodes.tile);
        const PlaceStep<Real> step = advance_place<false>(s.g.ends, v.table.position[b], held.border, sums.velocity,
                                                          s.g.dt, v.context.inverse_cell, u);
        if (step.moved > tally.moved) tally.moved = step.moved;
#pragma unroll
        for (int a = 0; a < 3; ++a) p.set_coordinate(a, u[a]);
        held.put(at, p.place, p.row[p.place]);
        p.row[p.motion] = held.take(at, p.motion);
        take_velocity(s.g.flip, sums, p);
        p.row[p.normal] = held.take(at, p.normal);
        p.row[p.shear] = held.take(at, p.shear);
        Row<Real> none[stretch_rows<3>];
        const Mat<Real, 3> dL = tensor_of<3>(s.g.dt * v.context.inverse_cell, sums.gradient);
        const std::uint32_t faults =
            step.faults | update_stress(law, inverse_density, dL, s.g.dt, v.p, held.home[i], p, none, tally, power);
#pragma unroll
        for (int r = 1; r < core_rows<3>; ++r) held.put(at, r, p.row[r]);
        const int code = move_code(step.move);
        if (faults) note_fault(account_of(v), faults, v.p.id[held.home[i]]);
        if (code == Block<3>::gone) {
            const double velocity[3] = {double(p.velocity(0)), double(p.velocity(1)), double(p.velocity(2))};
            note_loss<3>(account_of(v), s.g.quantum, double(p.mass()), velocity, s.g.gravity_impulse);
        }
        if (code == Block<3>::centre) return move_cell(step.move);
        return first_exit + (code == Block<3>::gone ? exits - 1 : code);
    }

    static __device__ __forceinline__ void gather(const Step& s, const Law& law, Real inverse_density, int b,
                                                  const Region& from, H& held, Seen<Real>& tally, double& power) {
        const std::uint32_t n = from.count();
        std::uint16_t* bin = held.bin[thread_now() / 32];
#pragma unroll 1
        for (unsigned r = 0; r < H::rounds_of(n); ++r) {
            const unsigned i = H::first_of(n) + 32 * r;
            if (i - i % 32 >= n) break;
            Copies::start(s, from, b, r + 1, held);
            wait_async<1>();
            int key = bins - 1;
            if (i < n) key = update(s, law, inverse_density, b, i, held, tally, power);
            const unsigned peers = __match_any_sync(all_lanes, key);
            const auto rank = unsigned(__popc(peers & ((1u << (i & 31)) - 1)));
            const unsigned before = bin[key];
            __syncwarp();
            if (rank == 0) bin[key] = std::uint16_t(before + unsigned(__popc(peers)));
            if (i < n) held.key[i] = std::uint16_t(unsigned(key) | (before + rank) << 7);
            __syncwarp();
        }
    }

    /// What the gather has seen, by warps; then, after a barrier, of the block.
    static __device__ __forceinline__ void note(const Seen<Real>& seen, double work, H& held) {
        const Real signal = warp_max(seen.signal), moved = warp_max(seen.moved);
#pragma unroll
        for (int d = 16; d > 0; d /= 2) work += __shfl_down_sync(all_lanes, work, d);
        const unsigned t = thread_now();
        if (t % 32 == 0) held.work[t / 32] = work, held.signal[t / 32] = signal, held.moved[t / 32] = moved;
    }
    static __device__ __forceinline__ void report(const Step& s, int b, const H& held) {
        if (thread_now() != threads - 1) return;
        BlockReport r{held.work[0], double(held.signal[0]), double(held.moved[0])};
        for (unsigned w = 1; w < threads / 32; ++w) {
            r.work += held.work[w];
            r.signal = max(r.signal, double(held.signal[w])), r.moved = max(r.moved, double(held.moved[w]));
        }
        s.report[b] = r;
    }

    template <bool Momentum, bool Force>
    static __device__ __forceinline__ void sum(const View<Real, 3>& v, Real cell_size, const H& held,
                                               SliceSums<Case>& sums) {
        each_sum<Momentum, Force>(sums, [](auto& x) { clear(x); });
        const SliceWeight<Case> slice(int(thread_now() / Case::cells));
        const unsigned cell = thread_now() % Case::cells;
        unsigned k = held.start[cell];
        const unsigned end = held.start[cell + 1];
        unsigned at = k < end ? H::at(held.order[k]) : 0;
#pragma unroll 1
        while (k < end) {
            Particle<Case> p;
#pragma unroll
            for (int r = 0; r < core_rows<3>; ++r) p.core.row[r] = held.take(at, r);
            if (++k < end) at = H::at(held.order[k]);
            add_particle<Case, Momentum, Force>(p, slice, 0, v.context, cell_size, Real(0), sums);
        }
        each_sum<Momentum, Force>(sums, [](auto& x) { take_outer_from_middle<Case>(x); });
    }
    template <bool Momentum, bool Force, class G>
    static __device__ __forceinline__ void each_sum(SliceSums<Case>& sums, const G& g) {
        if (Momentum) g(sums.mass);
#pragma unroll
        for (int q = 0; q < 3; ++q) {
            if (Momentum) g(sums.momentum[q]);
            if (Force) g(sums.force[q]);
        }
    }

    /// The sums' part of the tile; begins and ends with a barrier. freed(): after the first, when sums are complete.
    template <bool Momentum, bool Force, class Freed>
    static __device__ __forceinline__ void make_tile(const View<Real, 3>& v, const SliceSums<Case>& sums, H& held,
                                                     const Freed& freed) {
        constexpr int parts = int(Momentum) + int(Force);
        const unsigned t = thread_now();
        __syncthreads();
        freed();
        add_to_planes<Case, Momentum, Force>(sums, int(t / Case::cells), int(t % Case::cells), held.planes());
        __syncthreads();
        write_tiles<Case, Momentum ? 0 : 1, parts>(v, held.block, held.border, held.planes(), held.fold());
        __syncthreads();
    }
    /// summed(): sums are there, before a barrier; freed(): rows are free, after it.
    template <class Summed, class Freed>
    static __device__ __forceinline__ void scatter(const View<Real, 3>& v, Real cell_size, H& held,
                                                   const Summed& summed, const Freed& freed) {
        SliceSums<Case> sums;
        if constexpr (Passes == 1) {
            sum<true, true>(v, cell_size, held, sums);
            summed();
            make_tile<true, true>(v, sums, held, freed);
        } else {
            sum<true, false>(v, cell_size, held, sums);
            make_tile<true, false>(v, sums, held, [] {});
            sum<false, true>(v, cell_size, held, sums);
            summed();
            make_tile<false, true>(v, sums, held, freed);
        }
    }

    static __device__ __forceinline__ bool fits(std::uint32_t n) {
        return n > 0 && n <= unsigned(Capacity);
    }
};

/// A block without particles: its tile is zero since the last one left. Or one with too many.
template <class Real>
__device__ __forceinline__ void pass_by(const FusedStep<Real>& s, const Chosen& chosen, int b, std::uint32_t n) {
    if (n == 0)
        s.region[b] = {0, 0, 0, 0}, s.report[b] = {0, 0, 0};
    else if (chosen.block != s.overfull)
        s.overfull[atomicAdd(s.overfulls, 1u)] = b;
    else
        *s.error = 1;
}

inline constexpr const char* clock_names[] = {"ask", "nodes", "gather", "sort", "write", "p2g", "tile"};

/// Adds up what the first thread of a thread block takes from tick to tick.
template <bool Counts>
struct PhaseClock {
    unsigned long long* sums;
    long long last = 0;

    __device__ __forceinline__ void tick(int phase) {
        if constexpr (Counts) {
            if (thread_now() != 0) return;
            const long long now = clock64();
            if (phase >= 0) atomicAdd(sums + phase, static_cast<unsigned long long>(now - last));
            last = now;
        }
    }
};

/// Ahead: rows of the next block are asked for as soon as those of this one are summed.
template <class Real, class Law, int Capacity, int Passes, int Resident, bool Ahead, bool Clocks>
__global__ void __launch_bounds__(192, Resident)
    fused_step(const __grid_constant__ FusedStep<Real> s, const Chosen chosen, const __grid_constant__ Law law,
               const Real inverse_density, const Real cell_size) {
    using F = Fused<Real, Law, Capacity, Passes, Ahead>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& held = *reinterpret_cast<typename F::H*>(memory);
    let_next_launch_begin();
    wait_for_launch_before();
    PhaseClock<Clocks> clock{s.clocks};
    bool asked = false;
    for (std::uint32_t item = blockIdx.x; item < count_now(chosen); item += gridDim.x) {
        clock.tick(-1);
        const int b = asked ? held.next.block : chosen.block[item];
        const Region from = asked ? held.next.region : s.region[b];
        const std::uint32_t n = from.count();
        if (!F::fits(n)) {
            if (thread_now() == 0) pass_by(s, chosen, b, n);
            asked = false;
            continue;
        }
        const bool border = asked ? (held.next.border[0] >> 8 * (b & 3) & 255) != 0 : s.v.table.border[b] != 0;
        if (thread_now() == 0) held.block[0] = b, held.border = border;
        if (asked) {
            F::Copies::start_nodes(s.v, held.next.node_block, held.nodes.tile);
        } else {
            F::Copies::start_nodes(s.v, s.v.table.node_block + std::size_t(b) * Block<3>::corners, held.nodes.tile);
            F::Copies::start(s, from, b, 0, held);
        }
        F::Order::empty_bins(held);
        clock.tick(0);
        F::Copies::finish_nodes(s.v, b, border, held.nodes.tile);
        clock.tick(1);
        if (Ahead) F::Copies::ask_for_number(chosen, item + gridDim.x, held);
        Seen<Real> seen;
        double work = 0;
        F::gather(s, law, inverse_density, b, from, held, seen, work);
        F::note(seen, work, held);
        if (Ahead) wait_async<0>();
        clock.tick(2);
        F::Order::sort(n, held);
        clock.tick(3);
        if (Ahead) F::Copies::ask_for_rest(s, held);
        F::Order::write(s, b, n, held);
        F::report(s, b, held);
        clock.tick(4);
        asked = false;
        const auto start_next = [&](bool now) {
            if (!Ahead || !now || held.next.block < 0 || !F::fits(held.next.region.count())) return;
            F::Copies::start(s, held.next.region, held.next.block, 0, held);
            asked = true;
        };
        const auto summed = [&] {
            if (Ahead) wait_async<0>();
            clock.tick(5);
        };
        F::scatter(s.v, cell_size, held, summed, [&] { start_next(!border); });
        start_next(border);
        clock.tick(6);
    }
}

}  // namespace moraine::gpu::lab
