#pragma once
// Particle shifting (particle_shifting.hpp) as a term: added to the velocity that moves a particle.

#include "core/fluid/find_pressures.hpp"
#include "core/fluid/particle_shifting.hpp"
#include "core/terms/gather_point.hpp"
#include "core/terms/terms.hpp"

namespace moraine {

template <class Real, int Dim>
struct ShiftingTerm {
    static constexpr unsigned hooks = hook_block | hook_velocity;
    const FluidTerms<Real>* fluid;        ///< by body
    const Shifting<Real, Dim>* shifting;  ///< null: not in this step
    const HeldNode<Real, Dim>* held;      ///< [node block][node], where the pressure is the grid's; else null

    template <class Case>
    struct State {
        Real excess[Case::tile_nodes];  ///< e_i
    };

    MORAINE_HD bool on(const auto&) const { return shifting != nullptr; }

    /// nodes: of the tile, ghosts set.
    template <class Case>
    MORAINE_HD void at_block(const auto& of, int block, const Quad<Real>* nodes, State<Case>& state) const {
        int base[Dim];
        for (int a = 0; a < Dim; ++a) base[a] = first_node<typename Case::Shape>(of.table.position[block][a]);
        const auto volume = [&](int n) {  // v_i / h^d
            if (held) return held[of.stored_node(block, n)].filling;
            return nodes[2 * n][quad - 1] * nodes[2 * n + 1][quad - 1] * shifting->inverse_volume;
        };
        find_excess<typename Case::Shape>(*shifting, of.context.walls, base, volume, state.excess);
    }

    template <class Case>
    MORAINE_HD void on_velocity(const auto& of, const CellInWork<Case>& cell, const auto& point, State<Case>& state,
                                Quad<Real>& velocity) const {
        const Real shifts = fluid[of.p.body[point.slot]].shifting, dt = of.round.dt;
        if (!(shifts > Real(0))) return;
        const Real* excess = state.excess + tile_offset<Dim, Case::width>(cell.number);
        const Vec<Real, Dim> gradient = gradient_of_excess<typename Case::Shape>(point.stencil_of(), excess);
        const Real h = Real(1) / of.context.inverse_cell, most = Real(0.5) * h * h / shifts;
        Vec<Real, Dim> shift = shift_by(shifts, held && most < dt ? most : dt, h, gradient);
        if (of.table.border[cell.block]) {
            Vec<Real, Dim> move;
            for (int a = 0; a < Dim; ++a) move[a] = dt * velocity[a] * of.context.inverse_cell;
            keep_from_ends(shifting->ends, of.table.position[cell.block], of.p.position[point.slot], move, shift);
        }
        velocity = velocity + Quad<Real>::scaled(Real(1) / dt, shift);
    }
};

}  // namespace moraine
