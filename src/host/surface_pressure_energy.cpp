// The energy budget of cells beside surfaces on the host (core/nodes/surface_energy.hpp has that of nodes).

#include "core/fluid/pressure_kernels.hpp"
#include "host/surface_pressures.hpp"

namespace moraine {

/// What a cell's force takes from its nodes in a substep, by their mean velocities.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::count_taken(int k, int c, const Substep& substep) {
    const OpenCell<Real, Dim>& cell = cells_[static_cast<std::size_t>(k * cells + c)];
    const Structure<Dim>& s = on_.scene.field.structure[on_.cell_at(k, c).structure];
    double flux = 0, of_structure = 0;
    for (int a = 0; a < Dim; ++a) of_structure += double(cell.bed[a]) * s.velocity[a];
    of_structure += turned_flux(k, c);
    int n = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const CellNode<Real, Dim>& g = cell.factor[n++];
        const std::int32_t near = on_.node_at(k, tile_offset<Dim, 3>(c) + at);
        const Real* v = on_.values_at(k, tile_offset<Dim, 3>(c) + at);
        for (int a = 0; v && a < Dim; ++a)
            flux += 0.5 * double(g.gradient[a]) *
                    (double(v[a]) + double(on_.motions[static_cast<std::size_t>(near)].start[a]));
    });
    const double force = double(cell.state.pressure) + substep.damping() * double(cell.state.change);
    Energy& energy = energy_[static_cast<std::size_t>(k)];
    energy.cells.add(on_.scene.quantum.of(force * substep.dt * (flux - of_structure)));
    energy.structures.add(on_.scene.quantum.of(force * substep.dt * of_structure));
}

/// The work that the gather will do on a cell's particles (take_cell) [J].
template <class Real, int Dim>
double SurfacePressures<Real, Dim>::given_to_particles(int block, int c) const {
    const ListView<Dim> list = on_.patch.list();
    const HostCellParticles<Real, Dim> particles{on_.patch.particles.view(), on_.method.grid_bulk()};
    const CellStep<Real> step = CellStep<Real>::of(on_.scene.cells[first_cell(block) + std::size_t(c)]);
    const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (cells + 1) + c;
    double work = 0;
    for (std::uint32_t n = list.first[block] + bounds[0]; n < list.first[block] + bounds[1]; ++n) {
        const CellParticle<Real, Dim> q = particles(list.slot[n]);
        if (!(q.bulk > Real(0))) continue;
        const Real modulus = step.modulus(q.bulk);
        const Real by = taken_increment(step.increment, step.in_tension, borne_share(step.loose, modulus));
        work += double(q.volume) * (double(q.trace) / 3 + 0.5 * double(modulus * by)) * double(by);
    }
    return work;
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::take_energy(EnergyAccount& account) {
    for (Energy& energy : energy_) {
        account.pressures.add(energy.cells);
        account.nodes.contact.add(energy.structures);
        energy = {};
    }
}

template class SurfacePressures<float, 2>;
template class SurfacePressures<float, 3>;
template class SurfacePressures<double, 2>;
template class SurfacePressures<double, 3>;

}  // namespace moraine
