#pragma once
// The loops over particles, cells and nodes of water in the ground (water_cells.hpp), block by block, on the host.
//
// One team does a block, particles and cells in order, so that no result depends on who runs it.

#include "core/fluid/pressure_kernels.hpp"
#include "core/fluid/water_cells.hpp"
#include "core/nodes/water_nodes.hpp"

namespace moraine {

/// Nodes of a tile in the middle of its cells.
template <int Dim>
MORAINE_HD int middle_node(int cell) {
    constexpr int side = tile_side(3);
    return tile_offset<Dim, 3>(cell) + 1 + side + (Dim == 3 ? side * side : 0);
}

/// Tiles of the flux: (a, b w), and (P, mobility, b, R).
template <class Real, int Dim>
struct SumFlow {
    using Context = PressureContext<Real, Dim>;
    using Finder = PressureFinder<Real, Dim>;
    using Scratch = typename Finder::Nodes;

    Finder finder;
    ParticleView<Real, Dim> p;
    const PoreWater<Real>* pores;  ///< by body

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const Context& context = finder.context;
        const int block = finder.chosen[item];
        if (finder.list.count(block) == 0) return;
        Real* tile = context.grid.tiles + std::size_t(context.grid.tile_of[block]) * Context::tile_nodes * node_reals;
        team.each(Context::tile_nodes * node_reals, [&](int n) { tile[n] = Real(0); });
        team.each(Context::tile_nodes, [&](int n) { finder.load_node(block, n, scratch); });
        team.sync();
        for (int c = 0; c < Context::cells; ++c) add_cell(block, c, scratch, tile);
    }

  private:
    struct Means {
        Real volume = Real(0), pressure = Real(0), mobility = Real(0), storage = Real(0);
    };

    MORAINE_HD void add_cell(int block, int c, const Scratch& scratch, Real* tile) const {
        const std::uint32_t* bounds = finder.list.cell_first + std::size_t(block) * (Context::cells + 1) + c;
        if (bounds[0] == bounds[1]) return;
        const typename Finder::Found found = finder.begin(block, c, scratch);
        Means means;
        for (std::uint32_t k = finder.list.first[block] + bounds[0]; k < finder.list.first[block] + bounds[1]; ++k)
            add_particle(finder.list.slot[k], found.at.ghosts, tile + tile_offset<Dim, 3>(c) * node_reals, means);
        if (!found.cell.whole || !(means.volume > Real(0))) return;
        Real* middle = tile + middle_node<Dim>(c) * node_reals + quad;
        const Real h = Real(1) / finder.context.stencil.inverse_cell, inverse = Real(1) / means.volume;
        const Real most = Real(0.2) * h * h / (Real(4 * Dim) * means.storage * inverse * Real(finder.dt));
        const Real own = means.mobility * inverse;
        middle[0] = means.pressure * inverse;
        middle[1] = own < most ? own : most;
    }

    MORAINE_HD void add_particle(std::uint32_t s, const unsigned (&ghosts)[Dim], Real* to, Means& means) const {
        const PoreWater<Real>& pore = pores[p.body[s]];
        if (!pore.is_wet()) return;
        Weights<Real, Dim, Quadratic> n = stencil<Real, Dim, Quadratic>(finder.context.stencil, p, s);
        for (int a = 0; a < Dim; ++a) fold_weights<3>(ghosts[a], n.w[a], n.dw[a]);
        const Real volume = p.volume[s], porosity = pore.porosity_at(p.ln_J[s]);
        const Real inertia = volume * pore.inertia(porosity), drag = volume * pore.resistance;
        const Real water = volume * pore.density;
        each_node<Dim, 3>([&](int at, int i, int j, int k) {
            const int place[3] = {i, j, k};
            Real w = Real(1);
            for (int a = 0; a < Dim; ++a) w *= n.w[a][place[a]];
            Real* node = to + at * node_reals;
            node[0] += w * inertia;
            for (int a = 0; a < Dim; ++a) node[1 + a] += w * water * p.darcy_velocity[s][a];
            node[2 * quad - 2] += w * water;
            node[2 * quad - 1] += w * drag;
        });
        means.volume += volume;
        means.pressure -= volume * p.pore_pressure[s];
        means.mobility += volume / pore.resistance;
        means.storage += volume * pore.storage(porosity);
    }
};

/// From these tiles to what nodes hold. Cells are as full as they are of saturated soil: what lies beside it bears its
/// own stress. A cell that dry soil shares spreads no pressure.
template <class Real, int Dim>
struct HoldFlow {
    using Scratch = TileSums<Real, Dim>;

    BlockTable<Dim> table;
    TileView<Real> grid;
    const std::int32_t* chosen;  ///< node blocks
    WaterNode<Real, Dim>* node;
    HeldNode<Real, Dim>* held;
    Real full_mass;  ///< rho_w h^d [kg]

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int c = chosen[item];
        if (grid.node_of[c] < 0) return;
        scratch.find(team, table, grid, 3, c);
        team.each(Block<Dim>::cells, [&](int n) {
            const std::size_t at = std::size_t(grid.node_of[c]) * Block<Dim>::cells + std::size_t(n);
            WaterNode<Real, Dim>& w = node[at];
            const Quad<Real>&flow = scratch.sums[2 * n], &rest = scratch.sums[2 * n + 1];
            w = {};
            w.inertia = flow[0];
            w.pressure = rest[0], w.mobility = rest[1], w.water = rest[quad - 2], w.resistance = rest[quad - 1];
            Real& filling = held[at].filling;
            const Real wet = w.water / full_mass;
            if (wet < Real(0.95) * filling) w.mobility = Real(0);
            filling = wet;
            for (int a = 0; a < Dim; ++a) w.flux[a] = w.start[a] = w.water > Real(0) ? flow[1 + a] / w.water : Real(0);
        });
    }
};

/// What FindPressures reads of wet particles: all that a cell's volume is held by, K' + Q, and -p.
template <class Real, int Dim>
struct WetParticles {
    ParticleView<Real, Dim> p;
    const PoreWater<Real>* pores;
    WaterNodes<Real, Dim> water;
    Real dt;  ///< of the substep [s]

    MORAINE_HD CellParticle<Real, Dim> operator()(std::uint32_t s) const {
        CellParticle<Real, Dim> q;
        const PoreWater<Real>& pore = pores[p.body[s]];
        q.bulk = Real(0);
        if (!pore.is_wet()) return q;
        q.bulk = pore.drained_bulk + pore.storage(pore.porosity_at(p.ln_J[s]));
        q.volume = p.volume[s];
        q.trace = Real(-3) * p.pore_pressure[s];
        for (int a = 0; a < Dim; ++a) q.fraction[a] = fraction_of<Real>(p.position[s][a]);
        return q;
    }
    /// That moves a pressure's force as both do, with implicit drag as half of it more inertia (docs/theory/water.md):
    /// 1/y, y = (a* - 2 b + m) / (m a* - b^2), a* = a + dt R / 2 [kg].
    MORAINE_HD Real mass_of(std::size_t node, Real mass) const {
        const WaterNode<Real, Dim>& w = water.node[node];
        if (!(w.inertia > Real(0))) return mass;
        const Real a = w.inertia + Real(0.5) * dt * w.resistance, b = w.water;
        return (mass * a - b * b) / (a - Real(2) * b + mass);
    }
};

/// Parts what FindPressures found together: the modulus that is the water's, and P'.
template <class Real, int Dim>
struct PartCells {
    using Context = PressureContext<Real, Dim>;
    struct Scratch {};

    Context context;
    ParticleView<Real, Dim> p;
    const PoreWater<Real>* pores;
    ListView<Dim> list;
    const std::int32_t* chosen;
    WaterCell<Real>* water;  ///< [tile][cell]

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch&) const {
        const int block = chosen[item];
        if (list.count(block) == 0) return;
        const std::size_t first = context.first_cell(block);
        team.each(Context::cells, [&](int c) { part(block, c, first + std::size_t(c)); });
        team.sync();
        team.each(Context::cells, [&](int c) { fill_hole(block, c); });
    }

  private:
    MORAINE_HD void part(int block, int c, std::size_t at) const {
        CellPressure<Real>& cell = context.cell[at];
        water[at] = {};
        if (!(cell.volume > Real(0))) return;
        Real volume = Real(0), mean = Real(0), storage = Real(0), drained = Real(0);
        const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (Context::cells + 1) + c;
        for (std::uint32_t k = list.first[block] + bounds[0]; k < list.first[block] + bounds[1]; ++k) {
            const std::uint32_t s = list.slot[k];
            const PoreWater<Real>& pore = pores[p.body[s]];
            if (!pore.is_wet()) continue;
            volume += p.volume[s];
            mean += p.volume[s] * p.stress[s].trace() * Real(1.0 / 3.0);
            storage += p.volume[s] * pore.storage(pore.porosity_at(p.ln_J[s]));
            drained += p.volume[s] * pore.drained_bulk;
        }
        if (!(volume > Real(0))) return;
        const Real borne = cell.bulk * volume / (storage + drained);
        water[at].effective = borne * mean / volume;
        cell.bulk = borne * storage / volume;
    }

    /// A cell without particles takes P' as it takes P (PressureFinder::fill_hole).
    MORAINE_HD void fill_hole(int block, int c) const {
        const std::size_t first = context.first_cell(block);
        if (!(context.cell[first + std::size_t(c)].volume > Real(0)) || holds_particles(list, block, c)) return;
        Real volume = Real(0), sum = Real(0);
        each_cell_beside<Dim>(list, block, c, [&](int o) {
            const CellPressure<Real>& other = context.cell[first + std::size_t(o)];
            if (!(other.volume > Real(0))) return;
            volume += other.volume, sum += other.volume * water[first + std::size_t(o)].effective;
        });
        if (volume > Real(0)) water[first + std::size_t(c)].effective = sum / volume;
    }
};

/// A substep's forces, from cells to tiles: (spread, F), and those of P'.
template <class Real, int Dim>
struct SumPorePressures {
    using Context = PressureContext<Real, Dim>;
    struct Scratch {};

    Context context;
    KeptFactors<Real, Dim> kept;
    ListView<Dim> list;
    const std::int32_t* chosen;
    const WaterCell<Real>* water;
    const WaterNode<Real, Dim>* node;

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch&) const {
        const int block = chosen[item];
        if (list.count(block) == 0) return;
        Real* tile = context.grid.tiles + std::size_t(context.grid.tile_of[block]) * Context::tile_nodes * node_reals;
        team.each(Context::tile_nodes * node_reals, [&](int n) { tile[n] = Real(0); });
        team.sync();
        for (int c = 0; c < Context::cells; ++c) {
            const std::size_t at_cell = context.first_cell(block) + std::size_t(c);
            const CellPressure<Real>& cell = context.cell[at_cell];
            if (!(cell.volume > Real(0))) continue;
            press(at_cell, tile + tile_offset<Dim, 3>(c) * node_reals);
            if (cell.whole) spread(block, middle_node<Dim>(c), tile);
        }
    }

  private:
    MORAINE_HD void press(std::size_t at_cell, Real* to) const {
        const CellPressure<Real>& cell = context.cell[at_cell];
        const CellNode<Real, Dim>* factor = cell.whole ? context.whole : kept.of(at_cell);
        const Real effective = water[at_cell].effective;
        int n = 0;
        each_node<Dim, 3>([&](int at, int, int, int) {
            const CellNode<Real, Dim>& g = factor[n++];
            Real* q = to + at * node_reals;
            for (int a = 0; a < Dim; ++a) {
                q[1 + a] -= g.gradient[a] * cell.pressure;
                q[quad + a] -= g.gradient[a] * effective;
            }
        });
    }

    /// Of the three cells in a row along each axis whose middle one is here.
    MORAINE_HD void spread(int block, int middle, Real* tile) const {
        for (int a = 0, step = 1; a < Dim; ++a, step *= Context::side) {
            const WaterNode<Real, Dim>& before = node[context.stored(block, middle - step)];
            const WaterNode<Real, Dim>& own = node[context.stored(block, middle)];
            const WaterNode<Real, Dim>& after = node[context.stored(block, middle + step)];
            Real least = own.mobility < before.mobility ? own.mobility : before.mobility;
            least = least < after.mobility ? least : after.mobility;
            const Real second = least * (before.pressure - Real(2) * own.pressure + after.pressure);
            tile[(middle - step) * node_reals] += second;
            tile[middle * node_reals] -= Real(2) * second;
            tile[(middle + step) * node_reals] += second;
        }
    }
};

/// What a substep's velocities make of the cells.
template <class Real, int Dim>
struct UpdatePorePressures {
    using Context = PressureContext<Real, Dim>;
    struct Scratch {
        Vec<Real, Dim> velocity[Context::tile_nodes], flux[Context::tile_nodes];
        Real spread[Context::tile_nodes];
    };

    Context context;
    KeptFactors<Real, Dim> kept;
    ListView<Dim> list;
    const std::int32_t* chosen;
    WaterCell<Real>* water;
    const WaterNode<Real, Dim>* node;
    Real dt;    ///< dts [s]
    Real time;  ///< t/2, t: the middle of the substep, since the start of the step [s]

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int block = chosen[item];
        if (list.count(block) == 0) return;
        team.each(Context::tile_nodes, [&](int n) {
            const std::size_t at = context.stored(block, n);
            for (int a = 0; a < Dim; ++a) scratch.velocity[n][a] = context.grid.nodes[at * node_reals + std::size_t(a)];
            scratch.flux[n] = node[at].flux;
            scratch.spread[n] = node[at].spread;
        });
        team.sync();
        const Real h = Real(1) / context.stencil.inverse_cell, across = context.cell_volume() / (Real(4) * h * h);
        for (int c = 0; c < Context::cells; ++c) {
            const std::size_t at_cell = context.first_cell(block) + std::size_t(c);
            CellPressure<Real>& cell = context.cell[at_cell];
            if (!(cell.volume > Real(0))) continue;
            const CellNode<Real, Dim>* factor = cell.whole ? context.whole : kept.of(at_cell);
            const int corner = tile_offset<Dim, 3>(c);
            Real soil = Real(0), flow = Real(0);
            int n = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                const CellNode<Real, Dim>& g = factor[n++];
                for (int a = 0; a < Dim; ++a) {
                    soil += g.gradient[a] * scratch.velocity[corner + at][a];
                    flow += g.gradient[a] * scratch.flux[corner + at][a];
                }
            });
            if (cell.whole) flow -= across * scratch.spread[middle_node<Dim>(c)];
            const Real step = dt * (soil / cell.volume - time * cell.source), all = step + dt * flow / cell.volume;
            cell.change = cell.bulk * all;
            cell.pressure += cell.change;
            cell.increment += all;
            water[at_cell].increment += step;
        }
    }
};

}  // namespace moraine
