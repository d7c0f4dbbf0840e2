#include "host/host_water.hpp"

#include <cmath>

namespace moraine {

template <class Real, int Dim>
HostWater<Real, Dim>::HostWater(const Scene& scene, const Method<Host, Real, Dim>& method,
                                Patch<Host, Real, Dim>& patch, HostPressures<Real, Dim>& pressures)
    : scene_(scene), method_(method), patch_(patch), pressures_(pressures) {
    for (const BodySpec& body : scene.bodies)
        inverse_density_.push_back(
            static_cast<Real>(1 / scene.materials[static_cast<std::size_t>(body.material)].density));
}

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
            const Real before = p.mass[s] * inverse_density_[p.body[s]];
            const Real more = pore.density * (scene_.water.submerged ? -before : p.volume[s] - before);
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
    Host::launch_teams(static_cast<std::int64_t>(nodes.size()),
                       HoldFlow<Real, Dim>{patch_.table(), patch_.grid(), nodes.data(), nodes_.data()});
}

template <class Real, int Dim>
WaterNodes<Real, Dim> HostWater<Real, Dim>::nodes(const std::array<double, Dim>& gravity) {
    WaterNodes<Real, Dim> nodes;
    nodes.node = nodes_.data();
    nodes.full_mass = static_cast<Real>(scene_.water.density * std::pow(scene_.cell, Dim));
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
                   {p, method_.pores(), nodes({}), pressures_.held()},
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
