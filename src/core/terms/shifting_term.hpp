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
        Real excess[Case::tile_nodes];    ///< e_i
        Real distance[Case::tile_nodes];  ///< of surfaces [cells], where one is near
        bool near;
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
        const auto space = [&](int n) { return space_of<Case>(of, block, n); };
        find_excess<typename Case::Shape>(*shifting, of.context.walls, base, volume, space, state.excess);
        find_distances<Case>(of, base, space, state);
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
        if (state.near)
            keep_from_surfaces<Case>(point.stencil_of(), tile_offset<Dim, Case::width>(cell.number), state, shift);
        if (of.table.border[cell.block]) {
            Vec<Real, Dim> move;
            for (int a = 0; a < Dim; ++a) move[a] = dt * velocity[a] * of.context.inverse_cell;
            keep_from_ends(shifting->ends, of.table.position[cell.block], of.p.position[point.slot], move, shift);
        }
        velocity = velocity + Quad<Real>::scaled(Real(1) / dt, shift);
    }

  private:
    /// Of a node of the tile.
    template <class Case>
    MORAINE_HD const SpaceNode* space_of(const auto& of, int block, int n) const {
        if (!shifting->surfaces.near_of) return nullptr;
        int corner = 0, at = 0;
        for (int a = 0, rest = n; a < Dim; ++a, rest /= tile_side(Case::width)) {
            const int x = rest % tile_side(Case::width);
            corner |= (x >> 2) << a, at |= (x & 3) << (2 * a);
        }
        return shifting->surfaces.of(of.table.node_block[block * Block<Dim>::corners + corner], at);
    }
    template <class Case>
    MORAINE_HD void find_distances(const auto& of, const int* base, const auto& space, State<Case>& state) const {
        constexpr Real far = Real(100);
        state.near = false;
        for (int n = 0; shifting->surfaces.near_of && n < Case::tile_nodes; ++n) {
            const SpaceNode* node = space(n);
            state.distance[n] = node ? Real(node->distance) : far;
            state.near = state.near || state.distance[n] < Real(1.5);
        }
        if (!state.near) return;
        each_ghost(of.context.walls, base, tile_side(Case::width), [&](int ghost, int step) {
            const Real* first = state.distance + ghost + step;
            state.distance[ghost] = Real(2) * first[0] - first[step];
        });
    }
    template <class Case>
    static MORAINE_HD void keep_from_surfaces(const auto& stencil, int at, const State<Case>& state,
                                              Vec<Real, Dim>& shift) {
        Real distance = Real(0);
        each_node<Dim, Case::width>([&](int node, int i, int j, int k) {
            const int place[3] = {i, j, k};
            Real w = state.distance[at + node];
            for (int a = 0; a < Dim; ++a) w *= stencil.w[a][place[a]];
            distance += w;
        });
        keep_from_surface(distance, gradient_of_excess<typename Case::Shape>(stencil, state.distance + at), shift);
    }
};

}  // namespace moraine
