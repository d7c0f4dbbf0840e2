#pragma once
// The kernels of gpu/kernels/sleep/sleep.hpp.

#include "gpu/kernels/g2p/g2p_particle.cuh"
#include "gpu/kernels/sleep/sleep.hpp"
#include "gpu/kernels/sleep/sleep_warp.cuh"
#include "gpu/kernels/step_report.cuh"

namespace moraine::gpu {

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
    double most = s.kept_awake && s.kept_awake[b] && v.list.count(b) > 0 ? std::numeric_limits<double>::infinity() : 0;
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
