#pragma once
// The fused step: gather with stress, binning and the next particle to grid of one block, in one thread block.
//
//   1 gather   one thread per particle; rows are copied to shared memory at once, updated there, and keyed
//   2 sort     stable, by cell, then by exit of those who leave: counts of chunks of 32, added up
//   3 write    rows in the new order into the block's region
//   4 P2G      one thread per (cell, slice), as in the program, with rows from shared memory in the new order;
//              tile of those who stay. Passes: 1, or momentum, then force
//
// Who leaves is added to tiles by add_incoming.cuh. A block with more particles than fit goes on a list, which an
// instance with all of a multiprocessor's shared memory works off.

#include "device_lab/fused_layout.cuh"

namespace moraine::gpu::lab {

template <class Real, class Law, int Capacity, int Passes>
struct Fused {
    using Case = P2gCase<Real, 3, Quadratic, false>;
    using H = Held<Real, Capacity, Passes>;
    using F = FusedGather<Real, 3, Quadratic, Law, false, false, false, FluidGrid::none>;
    using Core = CoreRows<Real, 3>;
    using Step = FusedStep<Real>;
    static constexpr unsigned threads = Case::threads;
    static constexpr int rounds = (Capacity + int(threads) - 1) / int(threads);

    /// Asks for all rows, round by round.
    static __device__ __forceinline__ void start(const Step& s, const Region& from, int b, H& held) {
        const std::size_t base = std::size_t(b) * s.capacity;
        const std::uint32_t n = from.count();
#pragma unroll 1
        for (int r = 0; r < rounds; ++r) {
            const unsigned i = thread_now() + unsigned(r) * threads;
            if (i < n) {
                const std::size_t slot = base + from.place(i);
#pragma unroll
                for (int row = 0; row < core_rows<3>; ++row)
#pragma unroll
                    for (int u = 0; u < H::per_row; ++u)
                        copy_async<16>(&held.rows.unit[row * H::per_row + u][H::at(i)],
                                       reinterpret_cast<const uint4*>(s.v.p.core[row] + slot) + u);
                copy_async<4>(&held.home[i], s.home + slot);
            }
            if (r == 0 && i < unsigned(Block<3>::offsets)) {
                copy_async<4>(&held.neighbour[i], s.v.table.neighbour + std::size_t(b) * Block<3>::offsets + i);
                copy_async<4>(&held.number[i], s.number);
            }
            commit_async();
        }
    }

    /// Rows of a block that will be worked on when this one is done, into the L2 cache.
    static __device__ __forceinline__ void prefetch(const Step& s, const Chosen& chosen, std::uint32_t item) {
        if (s.ahead == 0 || item + s.ahead >= count_now(chosen)) return;
        const int b = chosen.block[item + s.ahead];
        const std::size_t base = std::size_t(b) * s.capacity;
        constexpr unsigned per_line = 128 / sizeof(Row<Real>);
        const std::uint32_t lines = (s.region[b].stay + per_line - 1) / per_line;
        for (unsigned k = thread_now(); k < lines * core_rows<3>; k += threads)
            asm volatile(
                "prefetch.global.L2 [%0];" ::"l"(s.v.p.core[k % core_rows<3>] + base + k / core_rows<3> * per_line));
    }

    static __device__ __forceinline__ void wait_for_round(int r) {
        if (rounds > 4 || r + 1 >= rounds) {
            wait_async<0>();
        } else if (r == 0) {
            wait_async<rounds - 1>();
        } else if (r == 1) {
            wait_async<(rounds > 2 ? rounds - 2 : 0)>();
        } else {
            wait_async<(rounds > 3 ? rounds - 3 : 0)>();
        }
    }

    /// Asks for the nodes of the block, which come before the rows: one group of copies.
    static __device__ __forceinline__ void start_nodes(const View<Real, 3>& v, int b, typename H::Tile& tile) {
        constexpr int side = Case::side, size = int(sizeof(Real));
        auto& nodes = nodes_of(tile);
#pragma unroll 1
        for (int n = int(thread_now()); n < Case::tile_nodes; n += int(threads)) {
            int corner = 0, at = 0, rest = n;
#pragma unroll
            for (int a = 0; a < 3; ++a, rest /= side) {
                corner |= (rest % side >> 2) << a;
                at |= (rest % side & 3) << (2 * a);
            }
            const std::int32_t block = v.table.node_block[b * Block<3>::corners + corner];  // node_of is the identity
            const Real* from = v.grid.nodes + (std::size_t(block) * Block<3>::cells + unsigned(at)) * node_reals;
            Real *row = nodes.row[n].e, *pair = nodes.pair[n].e;
            copy_async<2 * size>(row, from);
            copy_async<size>(row + 2, from + 2);
            copy_async<size>(row + 3, from + quad);
            copy_async<size>(pair, from + quad + 1);
            copy_async<size>(pair + 1, from + quad + 2);
        }
        commit_async();
    }

    /// Once they are there: ghosts and steps; ends with a barrier.
    static __device__ __forceinline__ void finish_nodes(const View<Real, 3>& v, int b, bool border,
                                                        typename H::Tile& tile) {
        wait_async<rounds>();
        __syncthreads();
        if (border) set_ghosts<3>(v, b, Quadratic::origin, nodes_of(tile));
        set_steps(tile);
    }
    template <int W>
    static __device__ __forceinline__ void set_steps(NodeTile<Real, 3, W>&) {}
    template <int W>
    static __device__ __forceinline__ void set_steps(StepTile<Real, 3, W>& tile) {
        for (int n = int(thread_now()); n < tile.node.size - 1; n += int(threads)) {
            auto step = tile.node.get(n + 1);
            step.combine(tile.node.get(n), [](Real x, Real y) { return x - y; });
            tile.step.set(n, step);
        }
        __syncthreads();
    }

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
                                                  std::uint32_t n, H& held, Seen<Real>& tally, double& power) {
        int r = 0;
#pragma unroll 1
        for (unsigned i = thread_now(); i / 32 * 32 < n; i += threads, ++r) {
            wait_for_round(r);
            int key = bins - 1;
            if (i < n) key = update(s, law, inverse_density, b, i, held, tally, power);
            const unsigned peers = __match_any_sync(all_lanes, key);
            const unsigned rank = unsigned(__popc(peers & ((1u << (i & 31)) - 1)));
            if (i < n) held.key[i] = std::uint16_t(unsigned(key) | rank << 8);
            if (rank == 0) held.bin[i / 32][key] = std::uint16_t(__popc(peers));
        }
    }

    /// From keys to the order; begins and ends with a barrier.
    static __device__ __forceinline__ void sort(std::uint32_t n, H& held) {
        __syncthreads();
        const unsigned t = thread_now();
        std::uint32_t mine = 0, upto = 0;
        if (t < bins) {
            const unsigned chunks = (n + 31) / 32;
            for (unsigned q = 0; q < chunks; ++q) {
                const std::uint32_t here = held.bin[q][t];
                held.bin[q][t] = std::uint16_t(mine);
                mine += here;
            }
            upto = scan_inclusive(mine);
            if (t % 32 == 31) held.part[t / 32] = upto;
        }
        __syncthreads();
        if (t < bins) {
            for (unsigned w = 0; w < t / 32; ++w) upto += held.part[w];
            held.start[t] = upto - mine;
        }
        __syncthreads();
        for (unsigned i = t; i < n; i += threads) {
            const unsigned key = held.key[i];
            held.order[held.start[key & 255] + held.bin[i / 32][key & 255] + (key >> 8)] = std::uint16_t(i);
        }
        __syncthreads();
    }

    /// Rows in their new order, and who goes where.
    static __device__ __forceinline__ void write(const Step& s, int b, std::uint32_t n, const H& held) {
        const std::size_t base = std::size_t(b) * s.capacity;
        const unsigned t = thread_now();
#pragma unroll 1
        for (unsigned k = t; k < n; k += threads) {
            const unsigned i = held.order[k], at = H::at(i);
#pragma unroll
            for (int r = 0; r < core_rows<3>; ++r) store_row(s.v.p.core[r] + base + k, held.take(at, r));
            s.home[base + k] = held.home[i];
        }
        const std::uint32_t stay = held.start[first_exit];
        if (t == 0) s.region[b] = {stay, n, 0, n - stay};
        if (stay == n || t > unsigned(exits)) return;
        const std::uint32_t from = held.start[first_exit + t];
        s.exit_at[std::size_t(b) * (exits + 1) + t] = std::uint16_t(from);
        if (t >= unsigned(Block<3>::offsets) || held.start[first_exit + t + 1] == from) return;
        const int to = int(held.neighbour[t]);
        if (to >= 0) s.claimed[to] = held.number[t];  // whoever else writes it writes the same
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
#pragma unroll 1
        for (; k < end; ++k) {
            const unsigned at = H::at(held.order[k]);
            Particle<Case> p;
#pragma unroll
            for (int r = 0; r < core_rows<3>; ++r) p.core.row[r] = held.take(at, r);
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

    /// The sums' part First, ... of the tile; begins and ends with a barrier.
    template <bool Momentum, bool Force>
    static __device__ __forceinline__ void make_tile(const View<Real, 3>& v, const SliceSums<Case>& sums, H& held) {
        constexpr int parts = int(Momentum) + int(Force);
        const unsigned t = thread_now();
        __syncthreads();
        add_to_planes<Case, Momentum, Force>(sums, int(t / Case::cells), int(t % Case::cells), held.planes());
        __syncthreads();
        write_tiles<Case, Momentum ? 0 : 1, parts>(v, held.block, held.border, held.planes(),
                                                   held.planes() + parts * Planes<Case>::part);
        __syncthreads();
    }
    template <class Summed>
    static __device__ __forceinline__ void scatter(const View<Real, 3>& v, Real cell_size, H& held,
                                                   const Summed& summed) {
        SliceSums<Case> sums;
        if constexpr (Passes == 1) {
            sum<true, true>(v, cell_size, held, sums);
            summed();
            make_tile<true, true>(v, sums, held);
        } else {
            sum<true, false>(v, cell_size, held, sums);
            make_tile<true, false>(v, sums, held);
            sum<false, true>(v, cell_size, held, sums);
            make_tile<false, true>(v, sums, held);
        }
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

template <class Real, class Law, int Capacity, int Passes, int Resident, bool Clocks>
__global__ void __launch_bounds__(192, Resident)
    fused_step(const __grid_constant__ FusedStep<Real> s, const Chosen chosen, const __grid_constant__ Law law,
               const Real inverse_density, const Real cell_size) {
    using F = Fused<Real, Law, Capacity, Passes>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& held = *reinterpret_cast<typename F::H*>(memory);
    let_next_launch_begin();
    wait_for_launch_before();
    PhaseClock<Clocks> clock{s.clocks};
    for (std::uint32_t item = blockIdx.x; item < count_now(chosen);) {
        const int b = chosen.block[item];
        clock.tick(-1);
        const Region from = s.region[b];
        const bool border = s.v.table.border[b] != 0;
        const std::uint32_t n = from.count();
        if (n == 0 || n > unsigned(Capacity)) {
            if (thread_now() == 0) pass_by(s, chosen, b, n);
            item += gridDim.x;
            continue;
        }
        if (thread_now() == 0) held.block[0] = b, held.item = item + gridDim.x, held.border = border;
        F::start_nodes(s.v, b, held.nodes.tile);
        F::start(s, from, b, held);
        for (unsigned k = thread_now(); k < (n + 31) / 32 * bins / 2; k += F::threads)
            reinterpret_cast<std::uint32_t*>(held.bin)[k] = 0;
        F::prefetch(s, chosen, item);
        clock.tick(0);
        F::finish_nodes(s.v, b, border, held.nodes.tile);
        clock.tick(1);
        Seen<Real> seen;
        double work = 0;
        F::gather(s, law, inverse_density, b, n, held, seen, work);
        F::note(seen, work, held);
        clock.tick(2);
        F::sort(n, held);
        clock.tick(3);
        F::write(s, b, n, held);
        F::report(s, b, held);
        clock.tick(4);
        F::scatter(s.v, cell_size, held, [&] { clock.tick(5); });
        clock.tick(6);
        item = held.item;
        __syncthreads();
    }
}

}  // namespace moraine::gpu::lab
