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

#include "device_lab/fused_layout.cuh"

namespace moraine::gpu::lab {

template <class Real, class Law, int Capacity, int Passes, bool Ahead>
struct Fused {
    using Case = P2gCase<Real, 3, Quadratic, false>;
    using H = Held<Real, Capacity, Passes, Ahead>;
    using F = FusedGather<Real, 3, Quadratic, Law, false, false, false, FluidGrid::none>;
    using Core = CoreRows<Real, 3>;
    using Step = FusedStep<Real>;
    static constexpr unsigned threads = Case::threads;
    static constexpr int rounds = (Capacity + int(threads) - 1) / int(threads);

    /// A warp has a part of the list of its own, 32 entries a round: how many, and the thread's entry of the first.
    static __device__ __forceinline__ unsigned rounds_of(std::uint32_t n) { return (n + threads - 1) / threads; }
    static __device__ __forceinline__ unsigned first_of(std::uint32_t n) {
        return thread_now() / 32 * 32 * rounds_of(n) + thread_now() % 32;
    }

    /// Asks for all rows, round by round.
    static __device__ __forceinline__ void start(const Step& s, const Region& from, int b, H& held) {
        const std::size_t base = std::size_t(b) * s.capacity;
        const std::uint32_t n = from.count();
#pragma unroll 1
        for (int r = 0; r < rounds; ++r) {
            const unsigned i = first_of(n) + unsigned(r) * 32;
            if (unsigned(r) < rounds_of(n) && i < n) {
                const std::size_t slot = base + from.place(i);
#pragma unroll
                for (int row = 0; row < core_rows<3>; ++row)
#pragma unroll
                    for (int u = 0; u < H::per_row; ++u)
                        copy_async<16>(&held.rows.unit[row * H::per_row + u][H::at(i)],
                                       reinterpret_cast<const uint4*>(s.v.p.core[row] + slot) + u);
                copy_async<4>(&held.home[i], s.home + slot);
            }
            if (const unsigned t = thread_now(); r == 0 && t < unsigned(Block<3>::offsets)) {
                copy_async<4>(&held.neighbour[t], s.v.table.neighbour + std::size_t(b) * Block<3>::offsets + t);
                copy_async<4>(&held.number[t], s.number);
            }
            commit_async();
        }
    }

    static __device__ __forceinline__ void wait_for_round(int r) {
        if (Ahead) return;
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
    static __device__ __forceinline__ void start_nodes(const View<Real, 3>& v, const std::int32_t* node_block,
                                                       typename H::Tile& tile) {
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
            const std::int32_t block = node_block[corner];  // node_of is the identity
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
        wait_async<(Ahead ? 0 : rounds)>();
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

    static __device__ __forceinline__ void empty_bins(H& held) {
        auto* words = reinterpret_cast<std::uint32_t*>(held.bin);
        for (unsigned k = thread_now(); k < H::warps * bins / 2; k += threads) words[k] = 0;
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
        std::uint16_t* bin = held.bin[thread_now() / 32];
#pragma unroll 1
        for (unsigned r = 0; r < rounds_of(n); ++r) {
            const unsigned i = first_of(n) + 32 * r;
            if (i - i % 32 >= n) break;
            wait_for_round(int(r));
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

    /// From keys to the order; begins and ends with a barrier. Each warp adds up all counts for itself: that is less
    /// than the barriers it would take to share the work.
    static __device__ __forceinline__ void sort(std::uint32_t n, H& held) {
        static_assert(bins == 96 && bins <= 128 && rounds * 32 <= 512);
        __syncthreads();
        const unsigned warp = thread_now() / 32, key = 3 * unsigned(lane_id());
        std::uint32_t all[3] = {0, 0, 0}, before[3] = {0, 0, 0};
#pragma unroll
        for (unsigned w = 0; w < H::warps; ++w)
#pragma unroll
            for (int j = 0; j < 3; ++j) {
                if (w == warp) before[j] = all[j];
                all[j] += held.bin[w][key + j];
            }
        const std::uint32_t sum = all[0] + all[1] + all[2], first = scan_inclusive(sum) - sum;
        const std::uint32_t start[3] = {first, first + all[0], first + all[0] + all[1]};
#pragma unroll
        for (int j = 0; j < 3; ++j) {
            held.place[warp][key + j] = std::uint16_t(start[j] + before[j]);
            if (warp == 0) held.start[key + j] = start[j];
        }
        __syncwarp();
        for (unsigned r = 0; r < rounds_of(n); ++r) {
            const unsigned i = first_of(n) + 32 * r;
            if (i >= n) break;
            const unsigned k = held.key[i];
            held.order[held.place[warp][k & 127] + (k >> 7)] = std::uint16_t(i);
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

    /// What is to be known of the next block comes while this one is worked on, in two steps: its number, the rest.
    /// Complete after wait_async<0> of the threads that asked and a barrier.
    static __device__ __forceinline__ void ask_for_number(const Chosen& chosen, std::uint32_t item, H& held) {
        if (thread_now() == 0) {
            if (item < count_now(chosen))
                copy_async<4>(&held.next.block, chosen.block + item);
            else
                held.next.block = -1;
        }
        commit_async();
    }
    static __device__ __forceinline__ void ask_for_rest(const Step& s, H& held) {
        const unsigned t = thread_now();
        const int b = held.next.block;
        if (b >= 0 && t < 4) {
            const std::int32_t* nodes = s.v.table.node_block + std::size_t(b) * Block<3>::corners;
            if (t < 2) copy_async<16>(&held.next.node_block[4 * t], nodes + 4 * t);
            if (t == 2) copy_async<16>(&held.next.region, s.region + b);
            if (t == 3) copy_async<4>(held.next.border, s.v.table.border + (b & ~3));
        }
        commit_async();
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
            F::start_nodes(s.v, held.next.node_block, held.nodes.tile);
        } else {
            F::start_nodes(s.v, s.v.table.node_block + std::size_t(b) * Block<3>::corners, held.nodes.tile);
            F::start(s, from, b, held);
        }
        F::empty_bins(held);
        clock.tick(0);
        F::finish_nodes(s.v, b, border, held.nodes.tile);
        clock.tick(1);
        if (Ahead) F::ask_for_number(chosen, item + gridDim.x, held);
        Seen<Real> seen;
        double work = 0;
        F::gather(s, law, inverse_density, b, n, held, seen, work);
        F::note(seen, work, held);
        if (Ahead) wait_async<0>();
        clock.tick(2);
        F::sort(n, held);
        clock.tick(3);
        if (Ahead) F::ask_for_rest(s, held);
        F::write(s, b, n, held);
        F::report(s, b, held);
        clock.tick(4);
        asked = false;
        const auto start_next = [&](bool now) {
            if (!Ahead || !now || held.next.block < 0 || !F::fits(held.next.region.count())) return;
            F::start(s, held.next.region, held.next.block, held);
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
