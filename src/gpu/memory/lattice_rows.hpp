#pragma once
// Particles of a lattice (core/data/lattice.hpp) into the rows of a device. Host and device run the same lines: a test
// on the host compares the rows with what seeding/seed.hpp makes.

#include "core/data/lattice.hpp"
#include "gpu/memory/particle_rows.hpp"

namespace moraine::gpu {

/// The cell whose part of a block's list entry k is in: bound[cell] <= k < bound[cell + 1].
template <int Dim>
MORAINE_HD int cell_at(const std::uint32_t* bound, std::uint32_t k) {
    int cell = 0;
    for (int step = Block<Dim>::cells / 2; step > 0; step /= 2)
        if (bound[cell + step] <= k) cell += step;
    return cell;
}

/// Into a slot whose rows are zeros where it has any besides the core.
template <class Real, int Dim>
MORAINE_HD void put_rows(const LatticeParticle<Real, Dim>& from, const Columns<Real, Dim>& to, std::uint32_t slot) {
    CoreRows<Real, Dim> rows{};
    for (int a = 0; a < Dim; ++a) {
        rows.set_coordinate(a, from.u[a]);
        rows.velocity(a) = from.velocity[a];
    }
    rows.mass() = from.mass;
    rows.volume() = from.volume;
    for (int k = 0; k < 3; ++k) rows.stress(k) = from.stress[k];
    for (int k = 0; k < core_rows<Dim>; ++k) to.core[k][slot] = rows.row[k];
    to.id[slot] = from.id;
    to.body[slot] = from.body;
}

}  // namespace moraine::gpu
