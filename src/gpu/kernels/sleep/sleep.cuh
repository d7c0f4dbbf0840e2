#pragma once
// The kernels of gpu/kernels/sleep/sleep.hpp.

#include "gpu/kernels/g2p/g2p_particle.cuh"
#include "gpu/kernels/sleep/sleep.hpp"
#include "gpu/kernels/step_report.cuh"

namespace moraine::gpu {

inline constexpr unsigned sleep_threads = 128;
inline constexpr unsigned sleep_warps = sleep_threads / 32;

/// Number of this warp in the launch.
__device__ __forceinline__ unsigned warp_number() {
    return blockIdx.x * sleep_warps + threadIdx.x / 32;
}

/// Calls f(slot) for the particles of block b, each on a lane.
template <int Dim, class F>
__device__ __forceinline__ void each_slot(const ListView<Dim>& list, int b, const F& f) {
    const std::uint32_t end = list.first[b + 1];
    for (std::uint32_t k = list.first[b] + static_cast<std::uint32_t>(lane_id()); k < end; k += 32) f(list.slot[k]);
    __syncwarp();
}

template <class Real, int Dim>
__device__ __forceinline__ RestSample<Real, Dim> sample_of(const Columns<Real, Dim>& columns, std::uint32_t s) {
    CoreRows<Real, Dim> p;
#pragma unroll
    for (int r = 0; r < core_rows<Dim>; ++r) p.row[r] = load_row(columns.core[r] + s);
    RestSample<Real, Dim> sample;
    sample.position = place_of<Real, Dim>(p);
#pragma unroll
    for (int a = 0; a < Dim; ++a) sample.velocity[a] = p.velocity(a);
    sample.mass = p.mass(), sample.volume = p.volume();
#pragma unroll
    for (int k = 0; k < Sym<Real, Dim>::size; ++k) sample.stress[k] = p.stress(k);
    return sample;
}

/// Its particles alone: by block it counts as asleep until the next binning. Whole warps call it.
template <class Real, int Dim>
__device__ __forceinline__ void wake_particles(const View<Real, Dim>& v, const SleepView<Dim>& s, int b) {
    each_slot(v.list, b, [&](std::uint32_t slot) { s.rest.place[slot] &= ~rest_word::asleep; });
}

/// Whole warps call it; all of the warp have asked `asleep` before.
template <class Real, int Dim>
__device__ __forceinline__ void wake_block(const View<Real, Dim>& v, const SleepView<Dim>& s, int b) {
    __syncwarp();
    wake_particles(v, s, b);
    if (lane_id() == 0) s.asleep[b] = 0;
}

template <class Real, int Dim>
__global__ void __launch_bounds__(sleep_threads)
    wake_entered_kernel(const __grid_constant__ View<Real, Dim> v, const __grid_constant__ SleepView<Dim> s,
                        const std::uint32_t* former_first) {
    const int b = static_cast<int>(warp_number());
    if (b >= v.table.own || !s.asleep[b]) return;
    if (v.list.count(b) != former_first[b + 1] - former_first[b]) wake_block(v, s, b);  // of sleepers nobody leaves
}

/// A thread per block; the warp wakes those of its blocks that have been walked into.
template <class Real, int Dim>
__global__ void __launch_bounds__(sleep_threads)
    find_sleepers_kernel(const __grid_constant__ View<Real, Dim> v, const __grid_constant__ SleepView<Dim> s,
                         const std::uint32_t* former_first) {
    const int b = static_cast<int>(blockIdx.x * sleep_threads + threadIdx.x);
    std::uint32_t sleeping = 0;
    bool entered = false;
    if (b < v.table.own) {
        const std::uint32_t begin = v.list.first[b], n = v.list.first[b + 1] - begin;
        entered = former_first && s.asleep[b] && n != former_first[b + 1] - former_first[b];
        const bool asleep = !entered && n > 0 && (s.rest.place[v.list.slot[begin]] & rest_word::asleep) != 0;
        s.asleep[b] = asleep;
        if (s.binned) s.binned[b] = asleep;
        sleeping = asleep ? n : 0;
    }
    for (unsigned left = __ballot_sync(all_lanes, entered); left != 0; left &= left - 1)
        wake_block(v, s, __shfl_sync(all_lanes, b, __ffs(static_cast<int>(left)) - 1));
    sleeping = __reduce_add_sync(all_lanes, sleeping);
    if (lane_id() == 0 && sleeping > 0)
        atomicAdd(word(&s.accounts[blockIdx.x % account_parts].particles), static_cast<unsigned long long>(sleeping));
}

template <class Real, int Dim>
__global__ void __launch_bounds__(sleep_threads)
    find_activity_kernel(const __grid_constant__ View<Real, Dim> v, const __grid_constant__ SleepView<Dim> s) {
    const int b = static_cast<int>(warp_number());
    if (b >= v.table.own) return;
    double most = 0;
    if (!s.asleep[b])
        each_slot(v.list, b, [&](std::uint32_t slot) {
            const double u =
                activity_since<Real, Dim>(s.rule, sample_of(v.p, slot), s.rest.place[slot], s.rest.stress[slot]);
            if (most < u) most = u;
        });
    most = warp_max(most);
    if (lane_id() == 0) s.activity[b] = most;
}

/// U of an own block, in all lanes.
template <int Dim>
__device__ __forceinline__ double activity_around(const BlockTable<Dim>& table, const double* activity, int b) {
    static_assert(Block<Dim>::offsets <= 32);
    double most = activity[b];
    if (lane_id() < Block<Dim>::offsets) {
        const std::int32_t n = table.neighbour[std::size_t(b) * Block<Dim>::offsets + std::size_t(lane_id())];
        if (n >= 0 && most < activity[n]) most = activity[n];
    }
    return warp_max(most);
}

/// Takes the motion of a block away, into the account.
template <class Real, int Dim>
__device__ __forceinline__ void put_to_sleep(const View<Real, Dim>& v, const SleepView<Dim>& s, int b,
                                             const Quantum& quantum) {
    ExactSum taken[1 + Dim];
    each_slot(v.list, b, [&](std::uint32_t slot) {
        const RestSample<Real, Dim> now = sample_of(v.p, slot);
        const double m = static_cast<double>(now.mass);
        double square = 0;
        for (int a = 0; a < Dim; ++a) {
            const double velocity = static_cast<double>(now.velocity[a]);
            square += velocity * velocity;
            taken[1 + a].add(quantum.of(m * velocity));
        }
        taken[0].add(quantum.of(0.5 * m * square));
        Row<Real>* motion = v.p.core[CoreRows<Real, Dim>::motion] + slot;
        for (int a = 0; a < Dim; ++a) motion->e[a] = Real(0);
        for (int r = 0; r < affine_rows<Dim>; ++r)
            if (v.p.affine[r]) store_row(v.p.affine[r] + slot, Row<Real>{});
        s.rest.place[slot] = rest_place<Real, Dim>(now.position) | rest_word::asleep;
        s.rest.stress[slot] = rest_stress(now.stress);
    });
    fold_sums(taken, s.accounts[blockIdx.x % account_parts].taken);
    if (lane_id() == 0) s.asleep[b] = 1, s.made[b] = {-1, -1};
}

template <class Real, int Dim>
__global__ void __launch_bounds__(sleep_threads, 4)
    change_kernel(const __grid_constant__ View<Real, Dim> v, const __grid_constant__ SleepView<Dim> s, bool first,
                  const Quantum quantum) {
    const int b = static_cast<int>(warp_number());
    if (b >= v.table.own || v.list.count(b) == 0) return;
    const bool asleep = s.asleep[b] != 0;
    const double around = activity_around<Dim>(v.table, s.activity, b);
    const SleepChange change = first ? SleepChange::none : sleep_change(s.rule, asleep, around);
    __syncwarp();  // all have asked whether it sleeps
    if (change == SleepChange::falls_asleep) return put_to_sleep(v, s, b, quantum);
    if (asleep && change == SleepChange::none) return;
    each_slot(v.list, b, [&](std::uint32_t slot) {
        const RestSample<Real, Dim> now = sample_of(v.p, slot);
        s.rest.place[slot] = rest_place<Real, Dim>(now.position);
        s.rest.stress[slot] = rest_stress(now.stress);
    });
    if (lane_id() == 0) s.asleep[b] = 0;
}

template <class Real, int Dim>
__global__ void __launch_bounds__(sleep_threads)
    choose_sums_kernel(const __grid_constant__ View<Real, Dim> v, const __grid_constant__ SleepView<Dim> s,
                       const Chosen chosen, std::int32_t made, bool all, ListToMake list) {
    if (blockIdx.x == 0 && threadIdx.x == 0) *list.emptied = 0;
    const std::uint32_t count = *chosen.count;
    for (std::uint32_t item = blockIdx.x * sleep_threads + threadIdx.x; item < count;
         item += gridDim.x * sleep_threads) {
        const int b = chosen.block[item];
        const bool asleep = s.asleep[b] != 0;
        const std::int32_t tile = v.grid.tile_of[b];
        const TileMark before = s.made[b];
        s.made[b] = asleep ? TileMark{tile, made} : TileMark{-1, -1};
        const bool keeps = !all && asleep && before.tile == tile && before.made == made;
        s.kept[b] = keeps;
        if (!keeps) list.block[atomicAdd(list.count, 1u)] = b;
    }
}

template <class Real, int Dim>
__global__ void __launch_bounds__(sleep_threads)
    keep_masses_kernel(const __grid_constant__ View<Real, Dim> v, const std::uint8_t* asleep, int nodes, Real* masses) {
    const int b = static_cast<int>(warp_number());
    if (b >= v.table.own || !asleep[b]) return;
    const std::size_t first = std::size_t(v.grid.tile_of[b]) * std::size_t(nodes);
    for (int n = lane_id(); n < nodes; n += 32) masses[first + n] = v.grid.tiles[(first + n) * node_reals];
}

/// The sum over a warp, in all lanes and in one fixed order.
__device__ __forceinline__ double sum_of_warp(double x) {
#pragma unroll
    for (int d = 16; d > 0; d /= 2) x += __shfl_xor_sync(all_lanes, x, d);
    return x;
}

/// Whether a sleeper has a fast node. If not, what its nodes would have given it is taken. Whole warps call it.
template <class Real, int Dim>
__device__ __forceinline__ bool has_fast_node(const View<Real, Dim>& v, const SleepView<Dim>& s,
                                              const HoldArgs<Real>& h, int b) {
    constexpr int corners = Block<Dim>::corners;
    const std::int32_t* node_block = v.table.node_block + std::size_t(b) * corners;
    const bool still = h.still_nodes && lane_id() < corners &&
                       has_tiles_of_sleepers_alone(v.table, v.grid.tile_of, s.asleep, node_block[lane_id()]);
    const unsigned still_corners = __ballot_sync(all_lanes, still);
    const int side = tile_side(h.width), nodes = power<Dim>(side);
    const std::size_t first = std::size_t(v.grid.tile_of[b]) * std::size_t(nodes);
    HeldByNodes<Dim> held;
    bool fast = false;
    for (int n = lane_id(); n < nodes; n += 32) {
        const Real m = h.masses ? h.masses[first + n] : v.grid.tiles[(first + n) * node_reals];
        if (!(m > Real(0))) continue;
        const CornerNode node = corner_node<Dim>(n, side);
        const std::size_t stored = std::size_t(node_block[node.corner]) * Block<Dim>::cells + std::size_t(node.at);
        held.fast = false;
        held.add(s.rule, static_cast<double>(m), v.grid.nodes + stored * node_reals);
        fast = fast || (held.fast && !((still_corners >> node.corner) & 1));
    }
    if (__any_sync(all_lanes, fast)) return true;
    ExactSum* taken = s.accounts[blockIdx.x % account_parts].taken;
    for (int i = 0; i <= Dim; ++i) {
        const double sum = sum_of_warp(i == 0 ? held.kinetic : held.momentum[i == 0 ? 0 : i - 1]);
        if (lane_id() == 0) add_exact(taken + i, h.quantum.of(sum));
    }
    return false;
}

/// All of a block stay in their cells.
template <class Real, int Dim>
__device__ __forceinline__ void stay(const View<Real, Dim>& v, int b) {
    const std::uint32_t begin = v.list.first[b], count = v.list.count(b);
    const std::uint32_t* bounds = v.list.cell_first + std::size_t(b) * (Block<Dim>::cells + 1);
    for (int c = lane_id(); c < Block<Dim>::cells; c += 32)
        for (std::uint32_t k = bounds[c]; k < bounds[c + 1]; ++k)
            v.moves[begin + k] = encode_move(Block<Dim>::centre, c);
    std::uint32_t* words = v.changed + begin / 32 + static_cast<std::uint32_t>(b);
    for (std::uint32_t w = static_cast<std::uint32_t>(lane_id()); 32 * w < count; w += 32) words[w] = 0;
}

/// Others ask meanwhile who sleeps, so who wakes is marked by its particles alone. Eight thread blocks of a
/// multiprocessor: without a number the compiler took 32 registers in 3-D, and spilled.
template <class Real, int Dim>
__global__ void __launch_bounds__(sleep_threads, 8)
    hold_kernel(const __grid_constant__ View<Real, Dim> v, const __grid_constant__ SleepView<Dim> s,
                const __grid_constant__ HoldArgs<Real> h, const __grid_constant__ AwakeLists lists) {
    if (blockIdx.x == 0 && threadIdx.x < 2) *lists.of[threadIdx.x].emptied = 0;
    const int b = static_cast<int>(warp_number());
    if (b >= v.table.own || v.grid.tile_of[b] < 0) return;
    const bool asleep = s.asleep[b] != 0;
    if (asleep && !has_fast_node(v, s, h, b)) {
        stay(v, b);
        if (lane_id() == 0) raise(account_of(v).signal, s.wave[b]);
        return;
    }
    if (asleep) wake_particles(v, s, b);
    const ListToMake& list = lists.of[lists.boundary[b] ? 0 : 1];
    if (lane_id() == 0) list.block[atomicAdd(list.count, 1u)] = b;
}

/// Of one warp.
template <int Dim>
__device__ __forceinline__ void make_sleep_report(SleepAccount<Dim>* accounts, bool with_taken,
                                                  SleepAccount<Dim>* report) {
    static_assert(account_parts % 32 == 0);
    SleepAccount<Dim> sum{};
    for (int i = lane_id(); i < account_parts; i += 32) {
        sum.particles += accounts[i].particles;
        accounts[i].particles = 0;
        for (int k = 0; k <= Dim && with_taken; ++k) {
            sum.taken[k].add(accounts[i].taken[k]);
            accounts[i].taken[k] = ExactSum{};
        }
    }
    ExactSum particles;
    particles.low = sum.particles;
    particles = warp_sum(particles);
    for (int k = 0; k <= Dim; ++k) sum.taken[k] = warp_sum(sum.taken[k]);
    if (lane_id() > 0) return;
    report->particles = particles.low;
    for (int k = 0; k <= Dim && with_taken; ++k) report->taken[k] = sum.taken[k];
}

template <int Dim>
__global__ void __launch_bounds__(32) count_sleepers_kernel(SleepAccount<Dim>* accounts, SleepAccount<Dim>* report) {
    make_sleep_report(accounts, false, report);
}

/// Two thread blocks, one for each report.
template <int Dim>
__global__ void __launch_bounds__(32) fold_reports_kernel(const __grid_constant__ ReportWork<Dim> step,
                                                          SleepAccount<Dim>* accounts, SleepAccount<Dim>* report) {
    if (blockIdx.x == 0)
        make_report(step);
    else
        make_sleep_report(accounts, true, report);
}

}  // namespace moraine::gpu
