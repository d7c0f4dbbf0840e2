#pragma once
// Tractions on the host (core/particles/traction.hpp), in scenes that have some. Each particle is alone, so nothing
// depends on who goes first.

#include <vector>

#include "blocks/patch.hpp"
#include "core/data/host.hpp"
#include "core/particles/traction.hpp"
#include "core/transfer/totals.hpp"

namespace moraine {

/// What each particle is given in this step. factors: by traction.
template <class Real, int Dim>
void set_loads(const std::vector<Traction<Real, Dim>>& tractions, const std::vector<double>& factors,
               Patch<Host, Real, Dim>& patch) {
    const ParticleView<Real, Dim> p = patch.particles.view();
    const ListView<Dim> list = patch.list();
    const std::span<const std::int32_t> blocks = patch.blocks();
    Host::launch(static_cast<std::int64_t>(blocks.size()), [&](int i) {
        const std::int32_t block = blocks[static_cast<std::size_t>(i)];
        for (std::uint32_t at = list.first[block]; at < list.first[block + 1]; ++at) {
            const std::uint32_t s = list.slot[at];
            ParticleLoad<Real, Dim> load{zero_vec<Real, Dim>(), zero_mat<Real, Dim>()};
            for (std::size_t k = 0; k < tractions.size(); ++k) {
                const Real place = p.load_place[s][static_cast<int>(k)];
                if (!(place > Real(0))) continue;
                const int scalar = tractions[k].density_scalar;
                add_load(tractions[k], static_cast<Real>(factors[k]), place, p.deformation[s], p.mass[s],
                         scalar < 0 ? tractions[k].inverse_density : Real(1) / p.history[scalar][s], load);
            }
            p.load_force[s] = load.force;
            p.load_couple[s] = load.couple;
        }
    });
}

/// Adds what they did in a block.
template <int Dim>
void count_loads(const BlockOutcome& out, const Quantum& quantum, Budget<Dim>& budget) {
    budget.load_work.add(quantum.of(out.load_work));
    for (std::size_t a = 0; a < Dim; ++a) budget.load_impulse[a].add(quantum.of(out.load_impulse[a]));
}

/// The same of the weight of pore water.
template <int Dim>
void count_weight(const BlockOutcome& out, const Quantum& quantum, Budget<Dim>& budget) {
    budget.water.weight.add(quantum.of(out.weight_work));
    for (std::size_t a = 0; a < Dim; ++a) budget.water.weight_impulse[a].add(quantum.of(out.weight_impulse[a]));
}

}  // namespace moraine
