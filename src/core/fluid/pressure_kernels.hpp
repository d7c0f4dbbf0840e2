#pragma once
// The loops over cells of grid_pressure.hpp, block by block: what they give their nodes, what they take.
//
// One team does a block, cells in order, so that no result depends on who runs it. Devices have kernels of their own
// (gpu/kernels/pressure/), by the same formulas.

#include "core/fluid/find_pressures.hpp"

namespace moraine {

template <class Real, int Dim>
struct CellViews {
    CellPressure<Real>* cell;         ///< [tile][cell]
    CellNode<Real, Dim>* factor;      ///< [tile][cell][3^d]; of cells that are not whole
    const HeldNode<Real, Dim>* held;  ///< [node block][node]
};

/// What stays of a cell's geometry through the substeps on the host: what each of its nodes takes.
template <class Real, int Dim>
struct KeptFactors {
    static constexpr std::size_t nodes = power<Dim>(3);
    CellNode<Real, Dim>* factor;  ///< [tile][cell][3^d]

    MORAINE_HD const CellNode<Real, Dim>* of(std::size_t cell) const { return factor + cell * nodes; }
    MORAINE_HD void keep(std::size_t cell, const CellMoments<Real, Dim>& moments, const CellBasis<Real>* basis,
                         Real inverse_cell) const {
        all_cell_nodes(moments, basis, inverse_cell, factor + cell * nodes);
    }
};

/// What the host's loops over cells read of particles.
template <class Real, int Dim>
struct HostCellParticles {
    ParticleView<Real, Dim> p;
    const Real* of_body;  ///< K [Pa]; 0: its pressure is its own

    MORAINE_HD CellParticle<Real, Dim> operator()(std::uint32_t s) const {
        CellParticle<Real, Dim> q;
        q.bulk = of_body[p.body[s]];
        if (!(q.bulk > Real(0))) return q;
        q.volume = p.volume[s];
        q.trace = p.stress[s].trace();
        for (int a = 0; a < Dim; ++a) q.fraction[a] = fraction_of<Real>(p.position[s][a]);
        return q;
    }
    /// Of a node under pressure [kg].
    MORAINE_HD Real mass_of(std::size_t, Real mass) const { return mass; }
};

/// A substep's forces, from cells to tiles.
template <class Real, int Dim>
struct SumPressures {
    using Context = PressureContext<Real, Dim>;
    struct Scratch {};

    Context context;
    KeptFactors<Real, Dim> kept;
    ListView<Dim> list;
    const std::int32_t* chosen;
    Real damping;  ///< d [-]

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
            const CellNode<Real, Dim>* factor = cell.whole ? context.whole : kept.of(at_cell);
            const Real force = cell.pressure + damping * cell.change;
            Real* to = tile + tile_offset<Dim, 3>(c) * node_reals;
            int n = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                const CellNode<Real, Dim>& node = factor[n++];
                Real* q = to + at * node_reals;
                for (int a = 0; a < Dim; ++a) q[quad + a] -= node.gradient[a] * force;
            });
        }
    }
};

/// What a substep's velocities make of the cells.
template <class Real, int Dim>
struct UpdatePressures {
    using Context = PressureContext<Real, Dim>;
    struct Scratch {
        Vec<Real, Dim> velocity[Context::tile_nodes];
    };

    Context context;
    KeptFactors<Real, Dim> kept;
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
            const std::size_t at_cell = context.first_cell(block) + std::size_t(c);
            CellPressure<Real>& cell = context.cell[at_cell];
            if (!(cell.volume > Real(0))) continue;
            const CellNode<Real, Dim>* factor = cell.whole ? context.whole : kept.of(at_cell);
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
