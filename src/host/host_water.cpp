#include "host/host_water.hpp"

#include <cmath>

#include "core/gravity.hpp"

namespace moraine {

template <class Real, int Dim>
HostWater<Real, Dim>::HostWater(const Scene& scene, const Method<Host, Real, Dim>& method,
                                Patch<Host, Real, Dim>& patch, HostPressures<Real, Dim>& pressures)
    : scene_(scene), method_(method), patch_(patch), pressures_(pressures) {}

template <class Real, int Dim>
void HostWater<Real, Dim>::set_weight(const std::array<double, Dim>& gravity) {
    const ParticleView<Real, Dim> p = patch_.particles.view();
    const ListView<Dim> list = patch_.list();
    const std::span<const std::int32_t> blocks = patch_.blocks();
    Host::launch(static_cast<std::int64_t>(blocks.size()), [&](int i) {
        const std::int32_t block = blocks[static_cast<std::size_t>(i)];
        for (std::uint32_t at = list.first[block]; at < list.first[block + 1]; ++at) {
            const std::uint32_t s = list.slot[at];
            if (!method_.needs.loads) p.load_force[s] = zero_vec<Real, Dim>();
            const PoreWater<Real>& pore = method_.pores()[p.body[s]];
            if (!pore.is_wet()) continue;
            const Real more = pore.more_mass(p.mass[s], p.volume[s]);
            for (int a = 0; a < Dim; ++a)
                p.load_force[s][a] += more * static_cast<Real>(gravity[static_cast<std::size_t>(a)]);
        }
    });
}

template <class Real, int Dim>
void HostWater<Real, Dim>::sum_flow(std::span<const std::int32_t> blocks, const Substep& substep) {
    pressures_.size_cells();
    Host::launch_teams(static_cast<std::int64_t>(blocks.size()),
                       SumFlow<Real, Dim>{{pressures_.context(), patch_.list(), method_.capacity, blocks.data(),
                                           substep.dt, substep.damping()},
                                          patch_.particles.view(),
                                          method_.pores()});
}

template <class Real, int Dim>
void HostWater<Real, Dim>::hold_flow() {
    nodes_.resize(patch_.stored_nodes());
    const std::span<const std::int32_t> nodes = patch_.node_blocks();
    Host::launch_teams(
        static_cast<std::int64_t>(nodes.size()),
        HoldFlow<Real, Dim>{patch_.table(), patch_.grid(), nodes.data(), nodes_.data(), pressures_.held(),
                            static_cast<Real>(scene_.water.density * std::pow(scene_.cell, Dim))});
}

template <class Real, int Dim>
WaterTerm<Real, Dim> HostWater<Real, Dim>::term() const {
    WaterTerm<Real, Dim> term{method_.pores(), pressures_.cells(), cells_.data(), nodes_.data(), {}, {}, {}};
    for (int a = 0; a < Dim; ++a) term.gravity[a] = static_cast<Real>(scene_.gravity[static_cast<std::size_t>(a)]);
    term.cavitation = static_cast<Real>(scene_.water.cavitation);
    if (!scene_.water.submerged) return term;
    const auto up = static_cast<std::size_t>(up_axis(scene_));
    term.still[static_cast<int>(up)] = static_cast<Real>(scene_.water.density * scene_.gravity[up] * scene_.cell);
    term.cavitation += static_cast<Real>(still_water(scene_, scene_.min[up] + 0.5 * scene_.cell));
    return term;
}

template <class Real, int Dim>
void HostWater<Real, Dim>::count(WaterAccount<Dim>& account) const {
    for (std::size_t k = 0; k < accounts_.size(); ++k) account.add(accounts_[k]);
}

template <class Real, int Dim>
WaterNodes<Real, Dim> HostWater<Real, Dim>::nodes(const std::array<double, Dim>& gravity, std::size_t solved) {
    WaterNodes<Real, Dim> nodes;
    nodes.node = nodes_.data();
    if (solved > 0) accounts_.resize(solved), nodes.account = accounts_.data();
    for (int a = 0; a < Dim; ++a) {
        const auto axis = static_cast<std::size_t>(a);
        nodes.weight[a] = scene_.water.submerged ? Real(0) : static_cast<Real>(gravity[axis]);
        for (int s = 0; s < 2; ++s) {
            const WallSpec& wall = scene_.walls[axis][static_cast<std::size_t>(s)];
            nodes.plane[a][s] = method_.context.walls.plane[a][s];
            nodes.closed[a][s] = !wall.drains && wall.kind != WallKind::open && wall.kind != WallKind::periodic;
        }
    }
    return nodes;
}

template <class Real, int Dim>
void HostWater<Real, Dim>::find(const Substep& first) {
    const std::span<const std::int32_t> blocks = patch_.blocks();
    const auto count = static_cast<std::int64_t>(blocks.size());
    const ParticleView<Real, Dim> p = patch_.particles.view();
    cells_.resize(static_cast<std::size_t>(patch_.tiles_in_use() + patch_.table().ghosts) * Block<Dim>::cells);
    Host::launch_teams(
        count, FindPressures<Real, Dim, WetParticles<Real, Dim>, KeptFactors<Real, Dim>>{
                   {pressures_.context(), patch_.list(), method_.capacity, blocks.data(), first.dt, first.damping()},
                   {p, method_.pores(), nodes({}), static_cast<Real>(first.dt)},
                   pressures_.factors()});
    Host::launch_teams(count, PartCells<Real, Dim>{pressures_.context(), p, method_.pores(), patch_.list(),
                                                   blocks.data(), cells_.data()});
}

template <class Real, int Dim>
void HostWater<Real, Dim>::sum(std::span<const std::int32_t> blocks) {
    Host::launch_teams(static_cast<std::int64_t>(blocks.size()),
                       SumPorePressures<Real, Dim>{pressures_.context(), pressures_.factors(), patch_.list(),
                                                   blocks.data(), cells_.data(), nodes_.data()});
}

template <class Real, int Dim>
void HostWater<Real, Dim>::update(const Substep& substep) {
    const std::span<const std::int32_t> blocks = patch_.blocks();
    Host::launch_teams(
        static_cast<std::int64_t>(blocks.size()),
        UpdatePorePressures<Real, Dim>{pressures_.context(), pressures_.factors(), patch_.list(), blocks.data(),
                                       cells_.data(), nodes_.data(), static_cast<Real>(substep.dt),
                                       static_cast<Real>(0.5 * (substep.number + 0.5) * substep.dt)});
}

template class HostWater<float, 2>;
template class HostWater<float, 3>;
template class HostWater<double, 2>;
template class HostWater<double, 3>;

}  // namespace moraine
