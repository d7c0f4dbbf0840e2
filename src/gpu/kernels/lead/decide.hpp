#pragma once
// The kernel that makes dt on the device, and sets it for the kernels behind it.
//
// It folds the last step's report (gpu/kernels/step_report.hpp), decides by engine/lead_rule.hpp whether the next step
// is made, and sets dt in the arguments of the kernels that take it: these are nodes of the graph that it is a node of
// itself, and device-updatable. Kernels keep their arguments by value, in constant memory, so none of them is slower or
// was changed for it. Where the lead ends it switches them off, and the particles stay as the last step left them.

#include <driver_types.h>

#include "engine/lead_rule.hpp"
#include "gpu/kernels/step_report.hpp"

namespace moraine::gpu {

/// The report of a step for the host, in pinned memory.
template <int Dim>
struct LeadEntry {
    Report<Dim> report;     ///< of the step before
    double dt;              ///< of this one [s]
    std::uint64_t clock;    ///< of the device, at the decision [ns]
    std::uint32_t goes_on;  ///< 1: this step is made; 0: the lead ended here
    std::uint32_t serial;   ///< written last
};
inline constexpr int lead_entries = 16;

/// What a lead begins with.
template <int Dim>
struct LeadBegin {
    LeadRule<Dim> rule;
    LeadClock<Dim> clock;
    LeadEntry<Dim>* entries;  ///< lead_entries, in pinned memory: a ring
    std::uint32_t serial;     ///< of the last entry before
    std::uint32_t tiles;      ///< blocks that there is space for
};

/// The state of a lead, on the device.
template <int Dim>
struct LeadState : LeadBegin<Dim> {
    Report<Dim> report;
    std::uint32_t number;  ///< of entries in this lead
    std::uint32_t ended;
};

/// A place in the arguments of a kernel.
struct LeadTarget {
    enum class Value { dt, gravity_impulse };
    cudaGraphDeviceNode_t node;
    std::uint64_t offset;
    Value value;
};

/// The kernels behind the decision of one step.
struct LeadNodes {
    const LeadTarget* target;
    int targets;
    const cudaGraphDeviceNode_t* node;  ///< to be switched off where the lead ends: with P2G of the step after
    int nodes;
};

/// Makes the last step's report, and sets dt for the next one's kernels. real_bytes: of dt in their arguments. A node
/// of the graph that holds `behind`.
template <int Dim>
void decide(const ReportWork<Dim>& work, LeadState<Dim>* state, const LeadNodes& behind, int real_bytes,
            cudaStream_t stream);

/// Begins a lead, and switches on the nodes that its graph has. Not in the graph.
template <int Dim>
void begin_lead(LeadState<Dim>* state, const LeadBegin<Dim>& begun, const cudaGraphDeviceNode_t* node, int nodes,
                cudaStream_t stream);

}  // namespace moraine::gpu
