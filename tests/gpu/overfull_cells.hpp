#pragma once
// Crowded samples: many particles in one cell, none in others.

#include "core/sample.hpp"

namespace moraine::test {

/// Every third block's particles move into the cell of its first one: a hundred and more in one cell, none in others.
template <class Real, int Dim>
void overfill(Sample<Real, Dim>& sample) {
    constexpr int cells = Block<Dim>::cells;
    const ListView<Dim> list = sample.patch.list();
    const ParticleView<Real, Dim> p = sample.patch.particles.view();
    for (int b = 0, occupied = 0; b < sample.patch.own(); ++b) {
        if (list.count(b) == 0 || occupied++ % 3 != 0) continue;
        int crowded = 0;
        const Vec<Coordinate<Real>, Dim> first = p.position[list.slot[list.first[b]]];
        for (int a = Dim - 1; a >= 0; --a) {
            const int cell = cell_of<Real>(first[a]);
            crowded = 4 * crowded + cell;
            const double low = 4.0 * sample.patch.table().position[b][a] + cell,
                         offset = sample.method.stencil.offset();
            const double most = sample.domain.nodes[static_cast<std::size_t>(a)] + offset;
            for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k)
                p.position[list.slot[k]][a] =
                    place<Real>(std::clamp(low + sample.uniform(0.001, 0.999), offset, most)).u;
        }
        auto* bounds = const_cast<std::uint32_t*>(list.cell_first) + b * (cells + 1);
        for (int c = 0; c <= cells; ++c) bounds[c] = c <= crowded ? 0 : list.count(b);
    }
}

template <class Real, int Dim>
int fullest_cell(const Sample<Real, Dim>& sample) {
    constexpr int cells = Block<Dim>::cells;
    const std::uint32_t* bounds = sample.patch.list().cell_first;
    std::uint32_t most = 0;
    for (int b = 0; b < sample.patch.own(); ++b)
        for (int c = 0; c < cells; ++c)
            most = std::max(most, bounds[b * (cells + 1) + c + 1] - bounds[b * (cells + 1) + c]);
    return static_cast<int>(most);
}

}  // namespace moraine::test
