// The host's engine: the grid's pressure and its substeps (core/fluid/grid_pressure.hpp).

#include "host/host_engine.hpp"
#include "host/host_surfaces.hpp"

namespace moraine {

template <class Real, int Dim>
void HostEngine<Real, Dim>::substep(SubstepStage stage, const Substep& substep, const StepScales<Dim>& step) {
    switch (stage) {
        case SubstepStage::find_pressures:
            return find_pressures(substep);
        case SubstepStage::sum_boundary:
            return sum_pressures(patch_.boundary(), substep);
        case SubstepStage::sum_interior:
            return sum_pressures(patch_.interior(), substep);
        case SubstepStage::solve_nodes:
            return solve_substep(substep, step);
    }
}

template <class Real, int Dim>
PressureContext<Real, Dim> HostEngine<Real, Dim>::pressure_context() {
    return {method_.context, patch_.table(), patch_.grid(), cells_.data(), held_.data(), whole_cell_.data()};
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::find_pressures(const Substep& first) {
    const auto tiles = static_cast<std::size_t>(patch_.tiles_in_use() + patch_.table().ghosts);
    cells_.resize(tiles * Block<Dim>::cells);
    factors_.resize(tiles * Block<Dim>::cells * PressureContext<Real, Dim>::nodes);
    const std::span<const std::int32_t> blocks = patch_.blocks();
    Host::launch_teams(
        static_cast<std::int64_t>(blocks.size()),
        FindPressures<Real, Dim, HostCellParticles<Real, Dim>, KeptFactors<Real, Dim>>{
            {pressure_context(), patch_.list(), method_.capacity, blocks.data(), first.dt, first.damping()},
            {patch_.particles.view(), method_.grid_bulk()},
            {factors_.data()}});
    if (!surfaces_) return;
    surfaces_->blocks.scene.cells = cells_.data();  // what is found near surfaces takes no part there
    surfaces_->cells.find(first);
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::sum_pressures(std::span<const std::int32_t> blocks, const Substep& substep) {
    Host::launch_teams(
        static_cast<std::int64_t>(blocks.size()),
        SumPressures<Real, Dim>{
            pressure_context(), {factors_.data()}, patch_.list(), blocks.data(), static_cast<Real>(substep.damping())});
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::solve_substep(const Substep& substep, const StepScales<Dim>& step) {
    NodeRound<Real, Dim> round = node_round(NodeTask::substep, substep.dt, step);
    round.first_substep = substep.is_first();
    round.step = static_cast<Real>(step.dt);
    if (surfaces_) surfaces_->cells.press(substep);
    solve(round, step);
    if (surfaces_) surfaces_->forces.act({substep.dt, step.dt}, substep.damping());
    const std::span<const std::int32_t> blocks = patch_.blocks();
    Host::launch_teams(static_cast<std::int64_t>(blocks.size()),
                       UpdatePressures<Real, Dim>{pressure_context(),
                                                  {factors_.data()},
                                                  patch_.list(),
                                                  blocks.data(),
                                                  static_cast<Real>(substep.dt),
                                                  static_cast<Real>(0.5 * (substep.number + 0.5) * substep.dt)});
    if (surfaces_) surfaces_->cells.update(substep);
    if (!surfaces_ || !scene_.output.energy_budget) return;
    surfaces_->forces.count_energy(round, energy_.data());
    surfaces_->cells.take_energy(report_.budget.energy);
}

template class HostEngine<float, 2>;
template class HostEngine<float, 3>;
template class HostEngine<double, 2>;
template class HostEngine<double, 3>;

}  // namespace moraine
