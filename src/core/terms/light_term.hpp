#pragma once
// Light nodes (light_nodes.hpp) as a term: takes from the gradient and C of a particle what its nodes cannot bear.

#include "core/grid/light_cell.hpp"
#include "core/terms/gather_point.hpp"
#include "core/terms/terms.hpp"

namespace moraine {

template <class Real>
struct LightTerm {
    static constexpr unsigned hooks = hook_cell | hook_rate;
    const Stiffness<Real>* stiffness;  ///< by body; null: nothing is limited
    ReactionLimits<Real> limits;

    template <class Case>
    struct State {
        LightCell<Real, Case::dim, Case::width> light;
    };

    MORAINE_HD bool on(const auto&) const { return stiffness != nullptr; }

    template <class Case>
    MORAINE_HD void at_cell(const auto&, const CellInWork<Case>& cell, State<Case>& state, const auto&) const {
        for (int a = 0; a < Case::dim; ++a) state.light.ghosts[a] = cell.ghosts[a];
        state.light.ready = false;
        state.light.least = least_mass<Case::dim, Case::width>(cell.nodes);
    }

    template <class Case>
    MORAINE_HD void on_rate(const auto& of, const CellInWork<Case>& cell, const auto& point, State<Case>& state) const {
        constexpr int Dim = Case::dim, width = Case::width;
        const std::uint32_t s = point.slot;
        auto& light = state.light;
        const Stiffness<Real>& k = stiffness[of.p.body[s]];
        if (!cell.at_wall && Real(2) * light.least >= k.full_mass) return;
        const auto n = point.stencil_of();
        LightStencil<Real, Dim, width> in;
        for (int a = 0; a < Dim; ++a)
            for (int i = 0; i < width; ++i) in.w[a][i] = n.w[a][i], in.dw[a][i] = n.dw[a][i];
        fold_stencil<typename Case::Shape, Case::affine>(light.ghosts, of.round.tpic, n.f, of.context.inverse_cell, in);
        if (!light.ready) weigh_nodes(cell.nodes, light);
        Real full = of.p.mass[s] / of.p.volume[s];  // rho h^d
        for (int a = 0; a < Dim; ++a) full /= of.context.inverse_cell;
        Vec<Real, Dim> reaction = reactions(in, full, light);
        const Real dt = of.round.dt;
        for (int b = 0; b < Dim; ++b) reaction[b] *= dt * dt * k.wave * of.p.volume[s] / of.p.mass[s];
        const LightShare<Real, Dim> share = light_share(limits, reaction, in.folded, k.dilation);
        if (share.whole) return;
        const auto taken = taken_gradients<Case::affine>(in, limits, share, [&](int at, int i, int j, int l) {
            const int index[3] = {cell.base[0] + i, cell.base[1] + j, Dim == 3 ? cell.base[Dim - 1] + l : 0};
            return acceleration<Real, Dim>(of.context.walls, index, cell.nodes[2 * at], cell.nodes[2 * at + 1]);
        });
        for (int b = 0; b < Dim; ++b)
            for (int a = 0; a < Dim; ++a) {
                point.sums.gradient(b)[a] += taken.seen(a, b);
                if constexpr (Case::affine) point.sums.affine(b)[a] += taken.kept(a, b);
            }
    }
};

}  // namespace moraine
