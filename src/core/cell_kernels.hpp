#pragma once
// The loops over cells of grid_pressure.hpp, block by block: what cells are, what they give their nodes, what they
// take.
//
// Cells of a block are indexed as its tile: state [tile][cell], factors [tile][cell][node of 3^d]. One team does a
// block, cells in order, so that no result depends on who runs it.

#include "core/grid_pressure.hpp"
#include "core/light_stencil.hpp"
#include "core/nodes.hpp"

namespace moraine {

template <class Real, int Dim>
struct CellViews {
    CellPressure<Real>* cell;         ///< [tile][cell]
    CellNode<Real, Dim>* factor;      ///< [tile][cell][3^d]; of cells that are not whole
    const HeldNode<Real, Dim>* held;  ///< [node block][node]
};

/// What all cells share.
template <class Real, int Dim>
struct CellContext {
    static constexpr int width = 3, side = tile_side(width);
    static constexpr int tile_nodes = power<Dim>(side), nodes = power<Dim>(3), cells = Block<Dim>::cells;

    StencilContext<Real, Dim> stencil;
    BlockTable<Dim> table;
    TileView<Real> grid;
    CellViews<Real, Dim> views;
    const CellNode<Real, Dim>* whole;  ///< [3^d]: whole_cell()

    MORAINE_HD std::size_t first_cell(int block) const { return std::size_t(grid.tile_of[block]) * cells; }
    MORAINE_HD CellNode<Real, Dim>* factors(int block, int c) const {
        return views.factor + (first_cell(block) + std::size_t(c)) * nodes;
    }
    MORAINE_HD Real cell_volume() const {
        Real v = Real(1);
        for (int a = 0; a < Dim; ++a) v /= stencil.inverse_cell;
        return v;
    }
    MORAINE_HD std::size_t stored(int block, int n) const { return stored_tile_node<width>(table, grid, block, n); }
};

/// Finds the cells of a step, with their pressures, factors and moduli.
template <class Real, int Dim>
struct FindCells {
    using Context = CellContext<Real, Dim>;
    static constexpr int cells = Context::cells, nodes = Context::nodes;

    struct Scratch {
        Real mass[Context::tile_nodes], filling[Context::tile_nodes];
        Vec<Real, Dim> velocity[Context::tile_nodes];
    };

    Context context;
    ParticleView<Real, Dim> p;
    ListView<Dim> list;
    NodeCapacity<Real, Dim> capacity;
    const Real* bulk;  ///< by body: K [Pa]; 0: its pressure is its own
    const std::int32_t* chosen;
    double dt;       ///< dts [s]
    double damping;  ///< d [-]

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int block = chosen[item];
        if (list.count(block) == 0) return;
        team.each(Context::tile_nodes, [&](int n) { load_node(block, n, scratch); });
        team.sync();
        for (int c = 0; c < cells; ++c) find_cell(block, c, scratch);
        for (int c = 0; c < cells; ++c) fill_hole(block, c);
    }

  private:
    MORAINE_HD void load_node(int block, int n, Scratch& scratch) const {
        const std::size_t at = context.stored(block, n);
        const Real* node = context.grid.nodes + at * node_reals;
        for (int a = 0; a < Dim; ++a) scratch.velocity[n][a] = node[a];
        scratch.mass[n] = node[quad - 1];
        int place[Dim];
        for (int a = 0, rest = n; a < Dim; ++a, rest /= Context::side)
            place[a] = first_node<Quadratic>(context.table.position[block][a]) + rest % Context::side;
        scratch.filling[n] = context.views.held[at].filling / capacity.of(place);
    }

    /// A cell's place, and whether a wall is at it.
    struct Place {
        int base[Dim];
        unsigned ghosts[Dim];
        bool inside;
    };

    MORAINE_HD Place place_of(int block, int c) const {
        const Walls<Real, Dim>& walls = context.stencil.walls;
        Place at;
        at.inside = true;
        for (int a = 0; a < Dim; ++a) {
            at.base[a] = first_node<Quadratic>(context.table.position[block][a]) + cell_coordinate<Dim>(c, a);
            at.ghosts[a] = context.table.border[block] ? walls.ghosts(a, at.base[a], 3) : 0u;
            for (int s = 0; s < 2; ++s) at.inside = at.inside && at.base[a] + 1 != walls.plane[a][s];
        }
        return at;
    }

    MORAINE_HD void find_cell(int block, int c, Scratch& scratch) const {
        CellPressure<Real>& cell = context.views.cell[context.first_cell(block) + std::size_t(c)];
        const Place at = place_of(block, c);
        const int corner = tile_offset<Dim, 3>(c);
        const Real share = share_of_integral(least_filling(at.ghosts, scratch.filling + corner));
        cell = {};
        cell.whole = at.inside && share == Real(1);
        CellMoments<Real, Dim> moments;
        moments.clear();
        const Real mine = sum_particles(block, c, cell.whole ? nullptr : &moments, cell);
        if (!(mine > Real(0)) && !(share > Real(0))) return;
        const CellNode<Real, Dim>* factor = context.whole;
        if (cell.whole) {
            cell.volume = context.cell_volume();
        } else {
            moments.scale(Real(1) - share);
            add_full(at.base, share, moments);
            cell.volume = moments.volume();
            CellBasis<Real> basis[Dim];
            for (int a = 0; a < Dim; ++a) basis[a] = cell_basis<Real>(at.ghosts[a]);
            factor = context.factors(block, c);
            all_cell_nodes(moments, basis, context.stencil.inverse_cell, context.factors(block, c));
        }
        for (int a = 0; a < Dim; ++a) {
            const Real s = cell.whole ? Real(0) : moments.m[a == 0 ? 1 : a == 1 ? 3 : 9] / cell.volume;
            cell.head += context.stencil.gravity_slope[a] * (Real(at.base[a]) + Real(0.5) + s);
        }
        cell.head += cell.pressure;
        close_cell(factor, corner, scratch, cell);
    }

    /// The least filling of the nodes in the domain.
    static MORAINE_HD Real least_filling(const unsigned (&ghosts)[Dim], const Real* filling) {
        Real least = Real(1);
        each_node<Dim, 3>([&](int at, int i, int j, int k) {
            if (is_inside<Dim>(ghosts, i, j, k) && filling[at] < least) least = filling[at];
        });
        return least;
    }

    /// Means of the particles, and their moments where they are wanted; returns their volume.
    MORAINE_HD Real sum_particles(int block, int c, CellMoments<Real, Dim>* moments, CellPressure<Real>& cell) const {
        Real volume = Real(0);
        const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (cells + 1) + c;
        for (std::uint32_t k = list.first[block] + bounds[0]; k < list.first[block] + bounds[1]; ++k) {
            const std::uint32_t s = list.slot[k];
            if (!(bulk[p.body[s]] > Real(0))) continue;
            volume += p.volume[s];
            if (moments) {
                Real f[Dim];
                for (int a = 0; a < Dim; ++a) f[a] = fraction_of<Real>(p.position[s][a]);
                moments->add(p.volume[s], f);
            }
            cell.pressure += p.volume[s] * p.stress[s].trace() * Real(1.0 / 3.0);
            cell.bulk += p.volume[s] * bulk[p.body[s]];
        }
        if (volume > Real(0)) cell.pressure /= volume, cell.bulk /= volume;
        return volume;
    }

    MORAINE_HD void add_full(const int* base, Real share, CellMoments<Real, Dim>& moments) const {
        if (!(share > Real(0))) return;
        Real x[Dim][cell_powers];
        for (int a = 0; a < Dim; ++a) full_moments(capacity, a, base[a] + 1, x[a]);
        moments.add_product(share * context.cell_volume(), x);
    }

    /// Source and bounded modulus, by the nodes. The pressure is the secant's.
    MORAINE_HD void close_cell(const CellNode<Real, Dim>* factor, int corner, const Scratch& scratch,
                               CellPressure<Real>& cell) const {
        Mat<Real, Dim> L = zero_mat<Real, Dim>();
        Real weight = Real(0);
        int n = 0;
        each_node<Dim, 3>([&](int at, int, int, int) {
            const CellNode<Real, Dim>& node = factor[n++];
            Real square = Real(0);
            for (int b = 0; b < Dim; ++b) {
                square += node.gradient[b] * node.gradient[b];
                for (int a = 0; a < Dim; ++a) L(a, b) += node.gradient[b] * scratch.velocity[corner + at][a];
            }
            if (scratch.mass[corner + at] > Real(0)) weight += square / scratch.mass[corner + at];
        });
        for (int a = 0; a < Dim; ++a)
            for (int b = 0; b < Dim; ++b) cell.source += L(a, b) * L(b, a);
        cell.source /= cell.volume * cell.volume;
        if (!(cell.bulk > Real(0))) return;  // a hole
        const Real bounded = weight > Real(0) ? bounded_bulk(cell.bulk, cell.volume, weight, dt, damping) : cell.bulk;
        cell.pressure *= bounded / cell.bulk;
        cell.bulk = bounded;
    }

    /// A cell without particles between full nodes takes what the cells of its block around it have, by volume.
    MORAINE_HD void fill_hole(int block, int c) const {
        CellPressure<Real>* of_block = context.views.cell + context.first_cell(block);
        CellPressure<Real>& hole = of_block[c];
        if (!(hole.volume > Real(0)) || hole.bulk > Real(0)) return;
        Real volume = Real(0), pressure = Real(0), head = Real(0), modulus = Real(0);
        for (int o = 0; o < cells; ++o) {
            bool beside = true;
            for (int a = 0; a < Dim; ++a) {
                const int d = cell_coordinate<Dim>(o, a) - cell_coordinate<Dim>(c, a);
                beside = beside && d >= -1 && d <= 1;
            }
            if (!beside || !(of_block[o].bulk > Real(0)) || !holds_particles(block, o)) continue;
            volume += of_block[o].volume;
            pressure += of_block[o].volume * of_block[o].pressure;
            head += of_block[o].volume * of_block[o].head;
            modulus += of_block[o].volume * of_block[o].bulk;
        }
        if (volume > Real(0))
            hole.pressure = pressure / volume, hole.head = head / volume, hole.bulk = modulus / volume;
        else
            hole.volume = Real(0);
    }

    MORAINE_HD bool holds_particles(int block, int c) const {
        const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (cells + 1) + c;
        return bounds[0] != bounds[1];
    }
};

/// A substep's forces, from cells to tiles; in the first one the means that smooth pressures besides:
/// sum_c w V (P_c + rho g.x) and sum_c w V in the first quad.
template <class Real, int Dim>
struct SumCells {
    using Context = CellContext<Real, Dim>;
    struct Scratch {};

    Context context;
    ListView<Dim> list;
    const std::int32_t* chosen;
    bool with_means;
    Real damping;  ///< d [-]

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch&) const {
        const int block = chosen[item];
        if (list.count(block) == 0) return;
        Real* tile = context.grid.tiles + std::size_t(context.grid.tile_of[block]) * Context::tile_nodes * node_reals;
        team.each(Context::tile_nodes * node_reals, [&](int n) { tile[n] = Real(0); });
        team.sync();
        for (int c = 0; c < Context::cells; ++c) {
            const CellPressure<Real>& cell = context.views.cell[context.first_cell(block) + std::size_t(c)];
            if (!(cell.volume > Real(0))) continue;
            const CellNode<Real, Dim>* factor = cell.whole ? context.whole : context.factors(block, c);
            const Real force = cell.pressure + damping * cell.change, head = cell.head;
            Real* to = tile + tile_offset<Dim, 3>(c) * node_reals;
            int n = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                const CellNode<Real, Dim>& node = factor[n++];
                Real* q = to + at * node_reals;
                for (int a = 0; a < Dim; ++a) q[quad + a] -= node.gradient[a] * force;
                if (with_means) q[0] += node.volume * head, q[1] += node.volume;
            });
        }
    }
};

/// What a substep's velocities make of the cells.
template <class Real, int Dim>
struct UpdateCells {
    using Context = CellContext<Real, Dim>;
    struct Scratch {
        Vec<Real, Dim> velocity[Context::tile_nodes];
    };

    Context context;
    ListView<Dim> list;
    const std::int32_t* chosen;
    Real dt;    ///< dts [s]
    Real time;  ///< t/2, t: the middle of the substep, since the start of the step [s]

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int block = chosen[item];
        if (list.count(block) == 0) return;
        team.each(Context::tile_nodes, [&](int n) {
            const Real* node = context.grid.nodes + context.stored(block, n) * node_reals;
            for (int a = 0; a < Dim; ++a) scratch.velocity[n][a] = node[a];
        });
        team.sync();
        for (int c = 0; c < Context::cells; ++c) {
            CellPressure<Real>& cell = context.views.cell[context.first_cell(block) + std::size_t(c)];
            if (!(cell.volume > Real(0))) continue;
            const CellNode<Real, Dim>* factor = cell.whole ? context.whole : context.factors(block, c);
            const Vec<Real, Dim>* velocity = scratch.velocity + tile_offset<Dim, 3>(c);
            Real flux = Real(0);
            int n = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                const CellNode<Real, Dim>& node = factor[n++];
                for (int a = 0; a < Dim; ++a) flux += node.gradient[a] * velocity[at][a];
            });
            const Real step = dt * (flux / cell.volume - time * cell.source);
            cell.change = cell.bulk * step;
            cell.pressure += cell.change;
            cell.increment += step;
        }
    }
};

}  // namespace moraine
