#include "host/host_energy.hpp"

#include "core/grid/binning.hpp"

namespace moraine {

/// -m g . (x - domain.min), by a gravity [m/s2], of a particle whose place is relative to the block `carry` blocks from
/// the own one [J].
template <class Real, int Dim>
double HostEnergy<Real, Dim>::potential_of(int block, std::uint32_t slot, const std::array<int, Dim>& carry,
                                           const std::array<double, Dim>& gravity) {
    const ParticleView<Real, Dim> p = patch_.particles.view();
    Vec<std::int32_t, Dim> position = patch_.table().position[block];
    for (int a = 0; a < Dim; ++a) position[a] += carry[static_cast<std::size_t>(a)];
    const std::array<double, Dim> x = place_in<Real, Dim>(scene_, method_.stencil, position, p.position[slot]);
    double potential = 0;
    for (std::size_t a = 0; a < Dim; ++a)
        potential -= static_cast<double>(p.mass[slot]) * gravity[a] * (x[a] - scene_.min[a]);
    return potential;
}

template <class Real, int Dim>
std::vector<double> HostEnergy<Real, Dim>::potentials_of(const std::vector<ContactPair>& pairs,
                                                         const std::array<double, Dim>& gravity) {
    std::vector<double> potentials(pairs.size());
    const ListView<Dim> list = patch_.list();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        const std::int32_t block = pairs[k].block;
        if (k > 0 && pairs[k - 1].block == block) continue;
        for (std::uint32_t i = list.first[block]; i < list.first[block + 1]; ++i)
            potentials[k] += potential_of(block, list.slot[i], {}, gravity);
    }
    return potentials;
}

template <class Real, int Dim>
void HostEnergy<Real, Dim>::note_put_out(const std::vector<double>& before, const std::vector<double>& after) {
    for (std::size_t k = 0; k < before.size(); ++k)
        if (before[k] != after[k]) put_out_.push_back(before[k] - after[k]);
}

/// What leaves through open ends. After the gather that moves, while lists still say where particles were: a motion is
/// less than a cell, so a cell of 3 that follows one of 0 is of the block below.
template <class Real, int Dim>
void HostEnergy<Real, Dim>::count_lost(const StepScales<Dim>& step, EnergyAccount& account) {
    const ParticleView<Real, Dim> p = patch_.particles.view();
    const ListView<Dim> list = patch_.list();
    for (const std::int32_t block : patch_.blocks()) {
        if (patch_.table().border[block] == 0) continue;
        const std::uint32_t* cells = list.cell_first + std::size_t(block) * (Block<Dim>::cells + 1);
        for (int c = 0; c < Block<Dim>::cells; ++c)
            for (std::uint32_t k = list.first[block] + cells[c]; k < list.first[block] + cells[c + 1]; ++k) {
                if (move_code(patch_.moves()[k]) != Block<Dim>::gone) continue;
                const std::uint32_t s = list.slot[k];
                std::array<int, Dim> carry{};
                double square = 0;
                for (int a = 0; a < Dim; ++a) {
                    const int way = cell_of<Real>(p.position[s][a]) - cell_coordinate<Dim>(c, a);
                    carry[static_cast<std::size_t>(a)] = way > 1 ? -1 : way < -1 ? 1 : 0;
                    const double v = static_cast<double>(p.velocity[s][a]);
                    square += v * v;
                }
                account.lost_kinetic.add(step.quantum.of(0.5 * static_cast<double>(p.mass[s]) * square));
                account.lost_potential.add(step.quantum.of(potential_of(block, s, carry, step.gravity)));
            }
    }
}

template <class Real, int Dim>
void HostEnergy<Real, Dim>::record(const StepScales<Dim>& step, bool moved, EnergyAccount& account) {
    if (!is_counted()) return;
    for (std::size_t k = 0; k < nodes_.size(); ++k) account.nodes.add(nodes_[k]);
    for (const double freed : put_out_) account.put_out.add(step.quantum.of(freed));
    put_out_.clear();
    if (moved) count_lost(step, account);
}

template class HostEnergy<float, 2>;
template class HostEnergy<float, 3>;
template class HostEnergy<double, 2>;
template class HostEnergy<double, 3>;

}  // namespace moraine
