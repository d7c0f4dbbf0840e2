// The engine's parts of a step where the pressure is the grid's (core/grid_pressure.hpp).

#include <cmath>

#include "gpu/engine.hpp"

namespace moraine::gpu {

/// The nodes begin their substeps.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::hold(const Round& round, const StepScales<Dim>& step) {
    HoldWork<Real, Dim> work{view(),
                             pressure_.view(),
                             method_.stencil.origin,
                             static_cast<Real>(step.mass_cutoff),
                             static_cast<Real>(std::pow(scene_.cell, -Dim)),
                             method_.shifts(),
                             method_.capacity,
                             light_marks_of(round),
                             {}};
    if (step.structures) work.contact = node_contact(*step.structures);
    pressure_kernels_.hold_nodes(work, stream_);
    summed_ = false;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find_cells(const Substep& first) {
    const auto find = [&](const Chosen& chosen, int blocks) {
        pressure_kernels_.find_cells(view(), pressure_.view(), method_.capacity, chosen, blocks, first, stream_);
    };
    if (exchange_) find(lists_.boundary(), boundary_blocks_);
    find(lists_.interior(), interior_blocks());
}

/// Cells take the velocities of the substep before with the sums of this one.
template <class Real, int Dim>
CellTask<Real> DeviceEngine<Real, Dim>::cell_task(const Substep& substep) const {
    return {!substep.is_first(), static_cast<Real>(substep.dt),
            static_cast<Real>(0.5 * (substep.number - 0.5) * substep.dt), true, static_cast<Real>(substep.damping())};
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum_boundary_cells(const Substep& substep) {
    if (!exchange_) return;
    exchange_->solved.record(stream_);
    exchange_->stream.wait_for(exchange_->solved);
    pressure_kernels_.advance_cells(view(), pressure_.view(), lists_.boundary(), boundary_blocks_, cell_task(substep),
                                    exchange_->stream);
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum_interior_cells(const Substep& substep) {
    pressure_kernels_.advance_cells(view(), pressure_.view(), lists_.interior(), interior_blocks(), cell_task(substep),
                                    stream_);
    if (exchange_) exchange_->halo.post();
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::solve_substep(const Substep& substep, const StepScales<Dim>& step) {
    NodeRound<Real, Dim> round = node_round(NodeTask::substep, substep.dt, step);
    round.first_substep = substep.is_first();
    round.step = static_cast<Real>(step.dt);
    const PressureView<Real, Dim> pressure = pressure_.view();
    const auto solve = [&](const NodeContact<Dim>* contact) {
        pressure_kernels_.solve_nodes(view(), pressure, method_.stencil, round, step.quantum, stream_, contact);
    };
    if (step.structures) {
        const NodeContact<Dim> contact = node_contact(*step.structures);
        solve(&contact);
        structures_.fetch(stream_);
    } else {
        solve(nullptr);
    }
    if (!substep.is_last()) return;
    CellTask<Real> task = cell_task({substep.number + 1, substep.count, substep.dt});
    task.sums = false;
    if (exchange_)
        pressure_kernels_.advance_cells(view(), pressure, lists_.boundary(), boundary_blocks_, task, stream_);
    pressure_kernels_.advance_cells(view(), pressure, lists_.interior(), interior_blocks(), task, stream_);
    watch_.end(1, stream_);
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
