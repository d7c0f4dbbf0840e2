#pragma once
// Particles of a lattice (core/data/lattice.hpp) into the host's columns: what begins as zero is made zero.

#include "core/data/lattice.hpp"
#include "core/particles/particles.hpp"

namespace moraine {

/// Every variable that no seed has is zero at the start; a law may change its own then (LawBatch::begin).
template <class Real, int Dim>
void clear_rest(const ParticleView<Real, Dim>& p, std::uint32_t slot) {
    each_variable<Real, Dim>([&](const auto& variable) {
        if (auto* column = variable.pointer(p); column && variable.starts == FirstValue::zero) column[slot] = {};
    });
}

template <class Real, int Dim>
void put_particle(const LatticeParticle<Real, Dim>& from, const ParticleView<Real, Dim>& p, std::uint32_t slot) {
    p.id[slot] = from.id;
    p.body[slot] = from.body;
    p.position[slot] = from.u;
    p.velocity[slot] = from.velocity;
    p.mass[slot] = from.mass;
    p.volume[slot] = from.volume;
    p.stress[slot] = zero_sym<Real, Dim>();
    for (int k = 0; k < 3; ++k) p.stress[slot][k] = from.stress[k];
    clear_rest(p, slot);
}

/// The block at `at`, into slots first, first + 1, ..., in the order (cell, id).
template <class Real, int Dim>
void fill_block(const LatticeView<Real, Dim>& lattice, const Vec<std::int32_t, Dim>& at, std::uint32_t first,
                const ParticleView<Real, Dim>& p) {
    for (int cell = 0; cell < Block<Dim>::cells; ++cell) {
        const std::uint32_t count = lattice.count(at, cell);
        for (std::uint32_t k = 0; k < count; ++k) put_particle(lattice.particle(at, cell, k), p, first++);
    }
}

}  // namespace moraine
