#pragma once
// The kernels of gpu/kernels/step_report.hpp: one warp, two accounts per lane.

#include "gpu/kernels/account.cuh"
#include "gpu/kernels/step_report.hpp"

namespace moraine::gpu {

template <int Dim>
__device__ __forceinline__ Account<Dim> empty_account() {
    Account<Dim> a{};
    a.faulty_id = ~std::uint64_t(0);
    return a;
}

/// Calls f(sum of a, sum of b) for each exact sum of two accounts.
template <int Dim, class F>
__device__ __forceinline__ void each_sum(Account<Dim>& a, const Account<Dim>& b, const F& f) {
    f(a.work, b.work);
    f(a.lost_mass, b.lost_mass);
    for (int i = 0; i < Dim; ++i) {
        f(a.impulse[i], b.impulse[i]);
        f(a.lost_momentum[i], b.lost_momentum[i]);
        f(a.lost_gravity_impulse[i], b.lost_gravity_impulse[i]);
    }
}

template <int Dim>
__device__ __forceinline__ void merge(Account<Dim>& a, const Account<Dim>& b) {
    a.signal = max(a.signal, b.signal);
    a.moved = max(a.moved, b.moved);
    a.square_speed = max(a.square_speed, b.square_speed);
    a.faulty_id = min(a.faulty_id, b.faulty_id);
    a.faults |= b.faults;
    a.clamped += b.clamped;
    a.lost_count += b.lost_count;
    each_sum(a, b, [](ExactSum& to, const ExactSum& from) { to.add(from); });
}

/// Over the warp, in all lanes.
template <int Dim>
__device__ __forceinline__ void merge_lanes(Account<Dim>& a) {
    a.signal = warp_max(a.signal);
    a.moved = warp_max(a.moved);
    a.square_speed = warp_max(a.square_speed);
    a.faulty_id = warp_min(a.faulty_id);
    a.faults = __reduce_or_sync(all_lanes, a.faults);
    a.clamped = __reduce_add_sync(all_lanes, a.clamped);
    ExactSum count;
    count.low = a.lost_count;
    a.lost_count = warp_sum(count).low;
    each_sum(a, a, [](ExactSum& sum, const ExactSum&) { sum = warp_sum(sum); });
}

/// Of one warp.
template <int Dim>
__device__ __forceinline__ void make_report(const ReportWork<Dim>& w) {
    Account<Dim> sum = empty_account<Dim>();
    for (int i = lane_id(); i < account_parts; i += 32) {
        merge(sum, w.accounts[i]);
        w.accounts[i] = empty_account<Dim>();
    }
    merge_lanes(sum);
    if (lane_id() > 0) return;
    *w.report = {sum,
                 *w.particles,
                 w.occupied[0],
                 w.occupied[1],
                 w.counters->stored,
                 {w.counters->migration_bound[0], w.counters->migration_bound[1]},
                 *w.in_guard_layer};
    w.counters->migration_bound[0] = w.counters->migration_bound[1] = 0;
}

template <int Dim>
__global__ void __launch_bounds__(32) report_kernel(const __grid_constant__ ReportWork<Dim> work) {
    make_report(work);
}

template <int Dim>
__global__ void __launch_bounds__(account_parts) empty_kernel(Account<Dim>* accounts) {
    accounts[threadIdx.x] = empty_account<Dim>();
}

}  // namespace moraine::gpu
