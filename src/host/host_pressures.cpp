#include "host/host_pressures.hpp"

namespace moraine {

template <class Real, int Dim>
HostPressures<Real, Dim>::HostPressures(const Method<Host, Real, Dim>& method, Patch<Host, Real, Dim>& patch)
    : method_(method), patch_(patch) {
    whole_cell(method.context.inverse_cell, whole_cell_.data());
}

template <class Real, int Dim>
PressureContext<Real, Dim> HostPressures<Real, Dim>::context() {
    return {method_.context, patch_.table(), patch_.grid(), cells_.data(), held_.data(), whole_cell_.data()};
}

template <class Real, int Dim>
void HostPressures<Real, Dim>::size_cells() {
    const auto tiles = static_cast<std::size_t>(patch_.tiles_in_use() + patch_.table().ghosts);
    cells_.resize(tiles * Block<Dim>::cells);
    factors_.resize(tiles * Block<Dim>::cells * PressureContext<Real, Dim>::nodes);
}

template <class Real, int Dim>
void HostPressures<Real, Dim>::find(const Substep& first) {
    size_cells();
    const std::span<const std::int32_t> blocks = patch_.blocks();
    Host::launch_teams(static_cast<std::int64_t>(blocks.size()),
                       FindPressures<Real, Dim, HostCellParticles<Real, Dim>, KeptFactors<Real, Dim>>{
                           {context(), patch_.list(), method_.capacity, blocks.data(), first.dt, first.damping()},
                           {patch_.particles.view(), method_.grid_bulk()},
                           {factors_.data()}});
}

template <class Real, int Dim>
void HostPressures<Real, Dim>::sum(std::span<const std::int32_t> blocks, const Substep& substep) {
    Host::launch_teams(
        static_cast<std::int64_t>(blocks.size()),
        SumPressures<Real, Dim>{
            context(), {factors_.data()}, patch_.list(), blocks.data(), static_cast<Real>(substep.damping())});
}

template <class Real, int Dim>
void HostPressures<Real, Dim>::update(const Substep& substep) {
    const std::span<const std::int32_t> blocks = patch_.blocks();
    Host::launch_teams(static_cast<std::int64_t>(blocks.size()),
                       UpdatePressures<Real, Dim>{context(),
                                                  {factors_.data()},
                                                  patch_.list(),
                                                  blocks.data(),
                                                  static_cast<Real>(substep.dt),
                                                  static_cast<Real>(0.5 * (substep.number + 0.5) * substep.dt)});
}

template class HostPressures<float, 2>;
template class HostPressures<float, 3>;
template class HostPressures<double, 2>;
template class HostPressures<double, 3>;

}  // namespace moraine
