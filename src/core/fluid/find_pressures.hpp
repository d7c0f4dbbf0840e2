#pragma once
// Finds the cells of a step (grid_pressure.hpp): their pressures, geometry and moduli, block by block.
//
// Cells of a block are indexed as its tile: state [tile][cell]. Host and devices read particles, keep the geometry and
// sum over nodes in ways of their own.

#include "core/fluid/grid_pressure.hpp"
#include "core/grid/light_stencil.hpp"
#include "core/nodes/nodes.hpp"

namespace moraine {

/// What all cells share.
template <class Real, int Dim>
struct PressureContext {
    static constexpr int width = 3, side = tile_side(width);
    static constexpr int tile_nodes = power<Dim>(side), nodes = power<Dim>(3), cells = Block<Dim>::cells;

    StencilContext<Real, Dim> stencil;
    BlockTable<Dim> table;
    TileView<Real> grid;
    CellPressure<Real>* cell;          ///< [tile][cell]
    const HeldNode<Real, Dim>* held;   ///< [node block][node]
    const CellNode<Real, Dim>* whole;  ///< [3^d]: whole_cell()

    MORAINE_HD std::size_t first_cell(int block) const { return std::size_t(grid.tile_of[block]) * cells; }
    MORAINE_HD Real cell_volume() const {
        Real v = Real(1);
        for (int a = 0; a < Dim; ++a) v /= stencil.inverse_cell;
        return v;
    }
    MORAINE_HD std::size_t stored(int block, int n) const { return stored_tile_node<width>(table, grid, block, n); }
};

/// A cell's place, and whether a wall is at it.
template <int Dim>
struct CellPlace {
    int base[Dim];  ///< first node of its stencil
    unsigned ghosts[Dim];
    bool inside;
};

template <class Real, int Dim>
MORAINE_HD CellPlace<Dim> cell_place(const Walls<Real, Dim>& walls, const BlockTable<Dim>& table, int block, int c) {
    CellPlace<Dim> at;
    at.inside = true;
    for (int a = 0; a < Dim; ++a) {
        at.base[a] = first_node<Quadratic>(table.position[block][a]) + cell_coordinate<Dim>(c, a);
        at.ghosts[a] = table.border[block] ? walls.ghosts(a, at.base[a], 3) : 0u;
        for (int s = 0; s < 2; ++s) at.inside = at.inside && at.base[a] + 1 != walls.plane[a][s];
    }
    return at;
}

/// Whether cell c of a block holds particles.
template <int Dim>
MORAINE_HD bool holds_particles(const ListView<Dim>& list, int block, int c) {
    const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (Block<Dim>::cells + 1) + c;
    return bounds[0] != bounds[1];
}

/// f(o) of the cells with particles of the block around its cell c.
template <int Dim, class F>
MORAINE_HD void each_cell_beside(const ListView<Dim>& list, int block, int c, const F& f) {
    for (int o = 0; o < Block<Dim>::cells; ++o) {
        bool beside = true;
        for (int a = 0; a < Dim; ++a) {
            const int d = cell_coordinate<Dim>(o, a) - cell_coordinate<Dim>(c, a);
            beside = beside && d >= -1 && d <= 1;
        }
        if (beside && holds_particles(list, block, o)) f(o);
    }
}

/// What a cell takes of a particle.
template <class Real, int Dim>
struct CellParticle {
    Real bulk;           ///< K [Pa]; 0: its pressure is its own, and nothing else is set
    Real volume;         ///< [m^d]
    Real trace;          ///< of its stress [Pa]
    Real fraction[Dim];  ///< place in the cell, 0 to 1
};

/// Cells of blocks with their pressures, geometry and moduli, a piece at a time: FindPressures below puts the pieces
/// together for one thread, gpu/kernels/pressure/found_pressures.cuh for a team.
template <class Real, int Dim>
struct PressureFinder {
    using Context = PressureContext<Real, Dim>;
    static constexpr int cells = Context::cells, nodes = Context::nodes;

    /// The nodes that a block's cells reach.
    struct Nodes {
        Real mass[Context::tile_nodes], filling[Context::tile_nodes];
        Vec<Real, Dim> velocity[Context::tile_nodes];
    };

    /// A cell under construction.
    struct Found {
        CellPlace<Dim> at;
        Real share;   ///< x: of the exact integrals [-]
        Real volume;  ///< sum_p V_p [m^d]
        Real lever;   ///< sum_p V_p rho g . s_p [N m]
        CellPressure<Real> cell;
    };

    Context context;
    ListView<Dim> list;
    NodeCapacity<Real, Dim> capacity;
    const std::int32_t* chosen;
    double dt;       ///< dts [s]
    double damping;  ///< d [-]

    MORAINE_HD void load_node(int block, int n, Nodes& loaded) const {
        const std::size_t at = context.stored(block, n);
        const Real* node = context.grid.nodes + at * node_reals;
        for (int a = 0; a < Dim; ++a) loaded.velocity[n][a] = node[a];
        loaded.mass[n] = node[quad - 1];
        loaded.filling[n] = context.held[at].filling;
        if (!context.table.border[block]) return;
        int place[Dim];
        for (int a = 0, rest = n; a < Dim; ++a, rest /= Context::side)
            place[a] = first_node<Quadratic>(context.table.position[block][a]) + rest % Context::side;
        loaded.filling[n] /= capacity.of(place);
    }

    MORAINE_HD Found begin(int block, int c, const Nodes& loaded) const {
        Found found = {};
        found.at = cell_place(context.stencil.walls, context.table, block, c);
        found.share = share_of_integral(least_filling(found.at.ghosts, loaded.filling + tile_offset<Dim, 3>(c)));
        found.cell.whole = found.at.inside && found.share == Real(1);
        return found;
    }

    /// volume, pressure, modulus: of a particle, the latter two times its volume. f: its place in the cell, 0 to 1.
    MORAINE_HD void add(Real volume, Real pressure, Real modulus, const Real* f, Found& found) const {
        Real lever = Real(0);
        for (int a = 0; a < Dim; ++a) lever += context.stencil.gravity_slope[a] * (f[a] - Real(0.5));
        found.volume += volume;
        found.lever += volume * lever;
        found.cell.pressure += pressure;
        found.cell.bulk += modulus;
    }

    /// Means, volume and head of the cell, and its moments if it is not whole; false: it takes no part.
    MORAINE_HD bool close_sums(Found& found, CellMoments<Real, Dim>& moments) const {
        CellPressure<Real>& cell = found.cell;
        if (found.volume > Real(0)) {
            cell.pressure /= found.volume, cell.bulk /= found.volume;
            cell.head = cell.pressure + found.lever / found.volume;
            for (int a = 0; a < Dim; ++a)
                cell.head += context.stencil.gravity_slope[a] * (Real(found.at.base[a]) + Real(0.5));
        }
        if (!(found.volume > Real(0)) && !(found.share > Real(0))) return false;
        if (cell.whole) {
            cell.volume = context.cell_volume();
        } else {
            moments.scale(Real(1) - found.share);
            add_full(found.at.base, found.share, moments);
            cell.volume = moments.volume();
        }
        return true;
    }

    /// Source and bounded modulus. L: sum_i v_i G_ic; weight: sum_i |G_ic|^2 / m_i. The pressure is the secant's.
    MORAINE_HD void close_cell(const Mat<Real, Dim>& L, Real weight, CellPressure<Real>& cell) const {
        for (int a = 0; a < Dim; ++a)
            for (int b = 0; b < Dim; ++b) cell.source += L(a, b) * L(b, a);
        cell.source /= cell.volume * cell.volume;
        if (!(cell.bulk > Real(0)) || cell.whole || !(weight > Real(0))) return;  // a hole, or no light node
        const Real bounded = bounded_bulk<Dim>(cell.bulk, cell.volume, weight, dt, damping);
        const Real share = bounded / cell.bulk;
        cell.loose = share < Real(1);
        cell.pressure *= share;
        cell.bulk = bounded;
    }

    /// A cell without particles between full nodes takes what the cells of its block around it have, by volume.
    MORAINE_HD void fill_hole(int block, int c) const {
        CellPressure<Real>* of_block = context.cell + context.first_cell(block);
        CellPressure<Real>& hole = of_block[c];
        if (!(hole.volume > Real(0)) || hole.bulk > Real(0)) return;
        Real volume = Real(0), pressure = Real(0), modulus = Real(0);
        each_cell_beside<Dim>(list, block, c, [&](int o) {
            if (!(of_block[o].bulk > Real(0))) return;
            volume += of_block[o].volume;
            pressure += of_block[o].volume * of_block[o].pressure;
            modulus += of_block[o].volume * of_block[o].bulk;
        });
        if (volume > Real(0))
            hole.pressure = pressure / volume, hole.bulk = modulus / volume;
        else
            hole.volume = Real(0);
    }

  private:
    /// The least filling of the nodes in the domain.
    static MORAINE_HD Real least_filling(const unsigned (&ghosts)[Dim], const Real* filling) {
        Real least = Real(1);
        unsigned any = 0;
        for (int a = 0; a < Dim; ++a) any |= ghosts[a];
        each_node<Dim, 3>([&](int at, int i, int j, int k) {
            if ((!any || is_inside<Dim>(ghosts, i, j, k)) && filling[at] < least) least = filling[at];
        });
        return least;
    }

    MORAINE_HD void add_full(const int* base, Real share, CellMoments<Real, Dim>& moments) const {
        if (!(share > Real(0))) return;
        Real x[Dim][cell_powers];
        for (int a = 0; a < Dim; ++a) full_moments(capacity, a, base[a] + 1, x[a]);
        moments.add_product(share * context.cell_volume(), x);
    }
};

/// The pieces in turn, a cell at a time. Particles gives a particle by its slot; Kept keeps what the nodes of a cell
/// take of it.
template <class Real, int Dim, class Particles, class Kept>
struct FindPressures {
    using Finder = PressureFinder<Real, Dim>;
    using Scratch = typename Finder::Nodes;

    Finder finder;
    Particles particles;
    Kept kept;

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int block = finder.chosen[item];
        if (finder.list.count(block) == 0) return;
        team.each(Finder::Context::tile_nodes, [&](int n) {
            finder.load_node(block, n, scratch);
            scratch.mass[n] = particles.mass_of(finder.context.stored(block, n), scratch.mass[n]);
        });
        team.sync();
        team.each(Finder::cells, [&](int c) { find_cell(block, c, scratch); });
        team.sync();
        team.each(Finder::cells, [&](int c) { finder.fill_hole(block, c); });
    }

  private:
    MORAINE_HD void find_cell(int block, int c, Scratch& scratch) const {
        const std::size_t index = finder.context.first_cell(block) + std::size_t(c);
        typename Finder::Found found = finder.begin(block, c, scratch);
        CellMoments<Real, Dim> moments;
        moments.clear();
        sum_particles(block, c, found, moments);
        const bool whole = found.cell.whole;
        if (!finder.close_sums(found, moments)) {
            finder.context.cell[index] = {};
            return;
        }
        if (!whole) {
            CellBasis<Real> basis[Dim];
            for (int a = 0; a < Dim; ++a) basis[a] = cell_basis<Real>(found.at.ghosts[a]);
            kept.keep(index, moments, basis, finder.context.stencil.inverse_cell);
        }
        const CellNode<Real, Dim>* factor = whole ? finder.context.whole : kept.of(index);
        const int corner = tile_offset<Dim, 3>(c);
        Mat<Real, Dim> L = zero_mat<Real, Dim>();
        Real weight = Real(0);
        each_node<Dim, 3>([&](int at, int, int, int) {
            const CellNode<Real, Dim>& node = *factor++;
            Real square = Real(0);
            for (int b = 0; b < Dim; ++b) {
                square += node.gradient[b] * node.gradient[b];
                for (int a = 0; a < Dim; ++a) L(a, b) += node.gradient[b] * scratch.velocity[corner + at][a];
            }
            if (scratch.mass[corner + at] > Real(0)) weight += square / scratch.mass[corner + at];
        });
        finder.close_cell(L, weight, found.cell);
        finder.context.cell[index] = found.cell;
    }

    MORAINE_HD void sum_particles(int block, int c, typename Finder::Found& found,
                                  CellMoments<Real, Dim>& moments) const {
        const ListView<Dim>& list = finder.list;
        const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (Finder::cells + 1) + c;
        for (std::uint32_t k = list.first[block] + bounds[0]; k < list.first[block] + bounds[1]; ++k) {
            const CellParticle<Real, Dim> q = particles(list.slot[k]);
            if (!(q.bulk > Real(0))) continue;
            if (!found.cell.whole) moments.add(q.volume, q.fraction);
            finder.add(q.volume, q.volume * q.trace * Real(1.0 / 3.0), q.volume * q.bulk, q.fraction, found);
        }
    }
};

}  // namespace moraine
