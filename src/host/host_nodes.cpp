// The host's engine: the nodes of a round and of the substeps of the grid's pressure, of those who sleep and of others.

#include <cmath>

#include "host/host_engine.hpp"
#include "host/host_surfaces.hpp"

namespace moraine {

template <class Real, int Dim>
NodeRound<Real, Dim> HostEngine<Real, Dim>::node_round(NodeTask task, double dt, const StepScales<Dim>& step) const {
    NodeRound<Real, Dim> round{task, static_cast<Real>(dt), {}, method_.damping, static_cast<Real>(step.mass_cutoff)};
    for (int a = 0; a < Dim; ++a) round.gravity[a] = static_cast<Real>(step.gravity[static_cast<std::size_t>(a)]);
    return round;
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::solve_nodes(const Round& round, const StepScales<Dim>& step) {
    if (round.nodes == NodeTask::hold) pressures_.hold();
    if (ends_ && solves(round.nodes)) {
        ends_->act(method_, patch_, node_round(round.nodes, step.dt, step));
        ends_->count(step.quantum, energy_.is_counted(), report_.budget);
    }
    solve(node_round(round.nodes, step.dt, step), step);
    if (!surfaces_) return;
    surfaces_->begin_step({step.structures->field(), step.quantum, static_cast<Real>(step.mass_cutoff),
                           pressures_.held(), nullptr, report_.felt.data(), report_.turning.data()},
                          *halo_, contact_.pairs);
    if (round.nodes == NodeTask::hold) return;
    surfaces_->forces.act({step.dt, step.dt}, 0);
    if (energy_.is_counted())
        surfaces_->forces.count_energy(node_round(round.nodes, step.dt, step), energy_.of_nodes());
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::solve(const NodeRound<Real, Dim>& round, const StepScales<Dim>& step) {
    if (step.structures) report_.felt.resize(step.structures->size());
    if (step.structures && step.structures->any_turns()) report_.turning.resize(step.structures->size());
    if (!step.structures || surfaces_) return solve<false>(round, step, {});
    solve<true>(round, step, contact_.field_with(*step.structures, report_.felt.data(), report_.turning.data()));
}

template <class Real, int Dim>
template <bool Contact>
void HostEngine<Real, Dim>::solve(const NodeRound<Real, Dim>& round, const StepScales<Dim>& step,
                                  const ContactField<Dim>& contact) {
    if (!sleepers_ || round.task != NodeTask::solve) return solve<Contact>(round, step, contact, patch_.node_blocks());
    const std::span<const std::int32_t> near = surfaces_ ? surfaces_->near_nodes() : std::span<const std::int32_t>{};
    if (sleepers_->find_still_nodes(Contact ? &contact : nullptr, near)) {
        NodeRound<Real, Dim> second = round;
        second.dt = Real(1);
        solve<false>(second, step, {}, sleepers_->still_nodes());
        sleepers_->keep_still_nodes(impulse_.data(), step.quantum);
    }
    solve<Contact>(round, step, contact, sleepers_->other_nodes());
}

template <class Real, int Dim>
template <bool Contact>
void HostEngine<Real, Dim>::solve(const NodeRound<Real, Dim>& round, const StepScales<Dim>& step,
                                  const ContactField<Dim>& contact, std::span<const std::int32_t> nodes) {
    if (energy_.is_counted())
        solve<Contact, true>(round, step, contact, nodes);
    else
        solve<Contact, false>(round, step, contact, nodes);
}

template <class Real, int Dim>
template <bool Contact, bool Energy>
void HostEngine<Real, Dim>::solve(const NodeRound<Real, Dim>& round, const StepScales<Dim>& step,
                                  const ContactField<Dim>& contact, std::span<const std::int32_t> nodes) {
    impulse_.resize(nodes.size() * Dim);
    const SolveNodes<Real, Dim, Contact, Energy> kernel{
        method_.context.walls,
        patch_.table(),
        patch_.grid(),
        nodes.data(),
        method_.stencil.width,
        method_.stencil.origin,
        round,
        step.quantum,
        impulse_.data(),
        contact,
        {contact_.pairs.structures(), contact_.pairs.tile_of().data(), contact_.gaps.data()},
        {pressures_.held(), static_cast<Real>(std::pow(scene_.cell, -Dim))},
        Energy ? energy_.of_nodes(nodes.size()) : energy_.of_nodes(),
        Energy && surfaces_ ? surfaces_->motions() : SurfaceMotions<Real, Dim>{},
        water_ ? water_->nodes(step.gravity, nodes.size()) : WaterNodes<Real, Dim>{}};
    Host::launch_teams(static_cast<std::int64_t>(nodes.size()), kernel);
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::wake_sleepers(const Round& round, const StepScales<Dim>& step) {
    const ContactField<Dim> field = step.structures ? step.structures->field() : ContactField<Dim>{};
    sleepers_->wake_by_nodes(step.dt, step.quantum, step.structures ? &field : nullptr, report_.budget);
    if (sleepers_->woken_nodes().empty()) return;
    Host::Array<ExactSum> counted;
    counted.swap(impulse_);
    solve<false>(node_round(round.nodes, step.dt, step), step, {}, sleepers_->woken_nodes());
    counted.swap(impulse_);
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::substep(SubstepStage stage, const Substep& substep, const StepScales<Dim>& step) {
    switch (stage) {
        case SubstepStage::sum_flow_boundary:
            return water_->sum_flow(patch_.boundary(), substep);
        case SubstepStage::sum_flow_interior:
            return water_->sum_flow(patch_.interior(), substep);
        case SubstepStage::hold_flow:
            return water_->hold_flow();
        case SubstepStage::find_pressures:
            if (water_) return water_->find(substep);
            pressures_.find(substep);
            if (!surfaces_) return;
            surfaces_->blocks.scene.cells = pressures_.cells();  // what is found near surfaces takes no part there
            return surfaces_->cells.find(substep);
        case SubstepStage::sum_boundary:
            return sum_pressures(patch_.boundary(), substep);
        case SubstepStage::sum_interior:
            return sum_pressures(patch_.interior(), substep);
        case SubstepStage::solve_nodes:
            return solve_substep(substep, step);
    }
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::sum_pressures(std::span<const std::int32_t> blocks, const Substep& substep) {
    water_ ? water_->sum(blocks) : pressures_.sum(blocks, substep);
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::solve_substep(const Substep& substep, const StepScales<Dim>& step) {
    NodeRound<Real, Dim> round = node_round(NodeTask::substep, substep.dt, step);
    round.first_substep = substep.is_first();
    round.step = static_cast<Real>(step.dt);
    if (surfaces_) surfaces_->cells.press(substep);
    solve(round, step);
    if (surfaces_) surfaces_->forces.act({substep.dt, step.dt}, substep.damping());
    water_ ? water_->update(substep) : pressures_.update(substep);
    if (surfaces_) surfaces_->cells.update(substep);
    if (!surfaces_ || !energy_.is_counted()) return;
    surfaces_->forces.count_energy(round, energy_.of_nodes());
    surfaces_->cells.take_energy(report_.budget.energy);
}

template class HostEngine<float, 2>;
template class HostEngine<float, 3>;
template class HostEngine<double, 2>;
template class HostEngine<double, 3>;

}  // namespace moraine
