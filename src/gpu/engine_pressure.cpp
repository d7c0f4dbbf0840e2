// The engine's parts of a step where the pressure is the grid's (core/fluid/grid_pressure.hpp).

#include <cmath>
#include <stdexcept>

#include "gpu/engine.hpp"

namespace moraine::gpu {

namespace {

/// Cells take the velocities of the substep before with the sums of this one.
template <class Real>
PressureTask<Real> pressure_task(const Substep& substep) {
    return {!substep.is_first(),
            static_cast<Real>(substep.dt),
            static_cast<Real>(0.5 * (substep.number - 0.5) * substep.dt),
            true,
            false,
            static_cast<Real>(substep.damping())};
}

}  // namespace

/// The nodes begin their substeps.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::hold(const Round& round, const StepScales<Dim>& step) {
    HoldWork<Real, Dim> work{view(),
                             fluid_.pressure.view(),
                             method_.stencil.origin,
                             static_cast<Real>(step.mass_cutoff),
                             static_cast<Real>(std::pow(scene_.cell, -Dim)),
                             method_.shifts(),
                             method_.capacity,
                             light_marks_of(round),
                             {}};
    if (step.structures)
        work.contact = contact_.find_at_nodes(*step.structures, epoch_.table.view(), method_.stencil, stream_);
    kernels_.pressure.hold_nodes(work, stream_);
    if (surfaces_) surfaces_->begin_step({view(), contact_, step, fluid_.pressure.view()}, stream_);
    summed_ = false;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::substep(SubstepStage stage, const Substep& substep, const StepScales<Dim>& step) {
    switch (stage) {
        case SubstepStage::sum_flow_boundary:
        case SubstepStage::sum_flow_interior:
        case SubstepStage::hold_flow:
            throw std::logic_error("devices have no water in the ground");
        case SubstepStage::find_pressures:
            return find_pressures(substep, step);
        case SubstepStage::sum_boundary:
            return sum_pressures(SharePart::boundary, substep);
        case SubstepStage::sum_interior:
            return sum_pressures(SharePart::interior, substep);
        case SubstepStage::solve_nodes:
            return solve_substep(substep, step);
    }
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find_pressures(const Substep& first, const StepScales<Dim>& step) {
    const PressureView<Real, Dim> pressure = fluid_.pressure.view();
    const auto find = [&](const Chosen& chosen, int part, int blocks) {
        kernels_.pressure.find_pressures(view(), pressure, method_.capacity, chosen, part, blocks, first, stream_);
    };
    kernels_.pressure.begin_lists(pressure, stream_);
    if (exchange_) find(epoch_.lists.boundary(), 0, boundary_blocks_);
    find(epoch_.lists.interior(), 1, interior_blocks());
    if (surfaces_) surfaces_->find_cells({view(), contact_, step, fluid_.pressure.view()}, first, stream_);
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum_pressures(SharePart part, const Substep& substep) {
    PressureTask<Real> task = pressure_task<Real>(substep);
    task.tells = part == SharePart::boundary;
    const auto advance = [&](int of, int blocks, cudaStream_t stream) {
        kernels_.pressure.advance_pressures(view(), fluid_.pressure.view(), of, blocks, task, stream);
    };
    if (part == SharePart::interior) {
        advance(1, interior_blocks(), stream_);
        if (exchange_) exchange_->halo.post();
    } else if (exchange_) {
        exchange_->solved.record(stream_);
        exchange_->stream.wait_for(exchange_->solved);
        advance(0, boundary_blocks_, exchange_->stream);
    }
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::solve_substep(const Substep& substep, const StepScales<Dim>& step) {
    NodeRound<Real, Dim> round = node_round(NodeTask::substep, substep.dt, step);
    round.first_substep = substep.is_first();
    round.step = static_cast<Real>(step.dt);
    const PressureView<Real, Dim> pressure = fluid_.pressure.view();
    const auto solve = [&](const NodeContact<Dim>* contact) {
        kernels_.pressure.solve_nodes(view(), pressure, method_.stencil, round, substep, step.quantum, stream_,
                                      contact);
    };
    const SurfaceShare<Real, Dim> share{view(), contact_, step, pressure};
    if (step.structures) {
        const NodeContact<Dim> contact =
            contact_.find_at_nodes(*step.structures, epoch_.table.view(), method_.stencil, stream_);
        if (surfaces_) surfaces_->press(share, substep, stream_);
        solve(surfaces_ ? nullptr : &contact);
        if (surfaces_) {
            surfaces_->act(share, {substep.dt, step.dt}, substep.damping(), stream_);
            surfaces_->find_fluxes(share, stream_);
        }
        contact_.structures.fetch(stream_);
    } else {
        solve(nullptr);
    }
    if (!substep.is_last()) return;
    PressureTask<Real> task = pressure_task<Real>({substep.number + 1, substep.count, substep.dt});
    task.sums = false;
    if (exchange_) kernels_.pressure.advance_pressures(view(), pressure, 0, boundary_blocks_, task, stream_);
    kernels_.pressure.advance_pressures(view(), pressure, 1, interior_blocks(), task, stream_);
    if (surfaces_) surfaces_->finish(share, substep, stream_);
    reports_.watch.end(1, stream_);
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
