#include "gpu/kernels/lead/decide.hpp"
#include "gpu/kernels/step_report.cuh"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

namespace {

constexpr int begin_threads = 64;

/// By one lane. Returns whether the next step is made.
template <int Dim>
__device__ bool decide_next(LeadState<Dim>& state) {
    const Report<Dim>& report = state.report;
    const Account<Dim>& account = report.account;
    const bool stops = account.faults != 0 || report.occupied() > state.tiles;
    const LeadReport last{__longlong_as_double(static_cast<long long>(account.signal)),
                          __longlong_as_double(static_cast<long long>(account.moved)), report.in_guard_layer != 0,
                          stops};
    const bool on = goes_on(state.rule, last, state.clock);
    state.ended = on ? 0 : 1;
    return on;
}

/// Writes an entry for the host; one lane.
template <int Dim>
__device__ void write_entry(LeadState<Dim>& state) {
    LeadEntry<Dim>& entry = state.entries[state.number++ % lead_entries];
    entry.report = state.report;
    entry.dt = state.clock.dt;
    std::uint64_t now;
    asm volatile("mov.u64 %0, %globaltimer;" : "=l"(now));
    entry.clock = now;
    entry.goes_on = state.ended ? 0 : 1;
    __threadfence_system();
    *static_cast<volatile std::uint32_t*>(&entry.serial) = ++state.serial;
}

template <int Dim>
__device__ void set(const LeadTarget& t, const LeadClock<Dim>& clock, int real_bytes) {
    if (t.value == LeadTarget::Value::gravity_impulse) {
        cudaGraphKernelNodeSetParam(t.node, t.offset, clock.gravity_impulse, sizeof(clock.gravity_impulse));
    } else if (real_bytes == sizeof(float)) {
        cudaGraphKernelNodeSetParam(t.node, t.offset, static_cast<float>(clock.dt));
    } else {
        cudaGraphKernelNodeSetParam(t.node, t.offset, clock.dt);
    }
}

template <int Dim>
__global__ void __launch_bounds__(32) decide_kernel(const __grid_constant__ ReportWork<Dim> work, LeadState<Dim>* state,
                                                    const __grid_constant__ LeadNodes behind, int real_bytes) {
    const bool over = state->ended != 0;
    bool on = false;
    if (!over) {
        make_report(work);
        if (lane_id() == 0) on = decide_next(*state);
        on = __shfl_sync(all_lanes, on, 0);
        __syncwarp();
    }
    if (on)
        for (int i = lane_id(); i < behind.targets; i += 32) set(behind.target[i], state->clock, real_bytes);
    else
        for (int i = lane_id(); i < behind.nodes; i += 32) cudaGraphKernelNodeSetEnabled(behind.node[i], false);
    __syncwarp();
    if (!over && lane_id() == 0) write_entry(*state);
}

template <int Dim>
__global__ void __launch_bounds__(begin_threads)
    begin_kernel(LeadState<Dim>* state, const __grid_constant__ LeadBegin<Dim> begun, const cudaGraphDeviceNode_t* node,
                 int nodes) {
    if (threadIdx.x == 0) {
        state->rule = begun.rule;
        state->clock = begun.clock;
        state->entries = begun.entries;
        state->serial = begun.serial;
        state->tiles = begun.tiles;
        state->number = state->ended = 0;
    }
    for (int i = static_cast<int>(threadIdx.x); i < nodes; i += begin_threads)
        cudaGraphKernelNodeSetEnabled(node[i], true);
}

}  // namespace

template <int Dim>
void decide(const ReportWork<Dim>& work, LeadState<Dim>* state, const LeadNodes& behind, int real_bytes,
            cudaStream_t stream) {
    decide_kernel<<<1, 32, 0, stream>>>(work, state, behind, real_bytes);
    check(cudaGetLastError(), "Deciding on the next step");
}

template <int Dim>
void begin_lead(LeadState<Dim>* state, const LeadBegin<Dim>& begun, const cudaGraphDeviceNode_t* node, int nodes,
                cudaStream_t stream) {
    begin_kernel<<<1, begin_threads, 0, stream>>>(state, begun, node, nodes);
    check(cudaGetLastError(), "Beginning steps on the device");
}

template void decide<2>(const ReportWork<2>&, LeadState<2>*, const LeadNodes&, int, cudaStream_t);
template void decide<3>(const ReportWork<3>&, LeadState<3>*, const LeadNodes&, int, cudaStream_t);
template void begin_lead<2>(LeadState<2>*, const LeadBegin<2>&, const cudaGraphDeviceNode_t*, int, cudaStream_t);
template void begin_lead<3>(LeadState<3>*, const LeadBegin<3>&, const cudaGraphDeviceNode_t*, int, cudaStream_t);

}  // namespace moraine::gpu
