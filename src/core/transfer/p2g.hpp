#pragma once
// Particles to grid.
//
//   m_i = sum_p w_ip m_p                                                       [kg]
//   q_i = sum_p w_ip m_p (v_p + C_p (x_i - x_p))                               [kg m/s]
//   f_i = sum_p (w_ip (m_p b_p + l_p) + (c_p - V_p sigma_p) grad w_ip)                         [N]
//   l_p, c_p: of tractions (particles/traction.hpp)
//   s_i = sum_p w_ip m_p (tr sigma_p / 3 + rho g . x_p), or sum_p w_ip V_p, for fluids that want it (NodeMean)
//
// Mass, momentum and internal force stay apart, so that no dt is needed yet. One team sums the
// particles of one block into its private tile: each cell's particles in list order into sums of
// its stencil, cells into the tile in order. Nothing is added by atomics, so the result does not
// depend on who runs it. Blocks are chosen by a list: boundary and interior blocks run this one kernel.

#include "core/data/grid_views.hpp"
#include "core/data/quad_pair.hpp"
#include "core/fluid/pressure_smoothing.hpp"
#include "core/grid/gather_sums.hpp"
#include "core/grid/stencil.hpp"

namespace moraine {

template <class Real, int Dim, class Shape, bool Affine>
struct ParticlesToGrid {
    static constexpr int width = Shape::width;
    static constexpr int side = tile_side(width);
    static constexpr int tile_nodes = power<Dim>(side);
    static constexpr int stencil_nodes = power<Dim>(width);

    struct Scratch {
        QuadPair<Real> sums[stencil_nodes];  ///< (mass, momentum) and force of each node of a cell's stencil
    };

    StencilContext<Real, Dim> context;
    ParticleView<Real, Dim> p;
    BlockTable<Dim> table;
    ListView<Dim> list;
    TileView<Real> grid;
    const std::int32_t* chosen;       ///< own blocks to sum
    Real cell;                        ///< h [m]
    NodeMean mean = NodeMean::none;   ///< s_i
    const Real* grid_bulk = nullptr;  ///< by body: not zero where the pressure is the grid's (grid_pressure.hpp)

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int block = chosen[item];
        if (list.count(block) == 0) return;
        Real* tile = grid.tiles + std::size_t(grid.tile_of[block]) * tile_nodes * node_reals;
        team.each(tile_nodes * node_reals, [&](int n) { tile[n] = Real(0); });
        team.sync();
        team.each(Block<Dim>::cells, [&](int c) { add_cell(block, c, scratch.sums, tile); });
        if (!Affine && Shape::width > 2 && table.border[block]) fold_ghosts(block, tile);
    }

  private:
    using Q = Quad<Real>;
    using Pair = QuadPair<Real>;
    using Factors = typename Pair::Factors;
    using Number = typename Factors::Number;  ///< a weight in every lane of a pair

    MORAINE_HD void add_cell(int block, int c, Pair* sums, Real* tile) const {
        const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (Block<Dim>::cells + 1) + c;
        if (bounds[0] == bounds[1]) return;
        for (int n = 0; n < stencil_nodes; ++n) sums[n] = Pair::of(Q::zero(), Q::zero());
        int base[Dim];
        for (int a = 0; a < Dim; ++a)
            base[a] = first_node<Shape>(table.position[block][a]) + cell_coordinate<Dim>(c, a);
        const bool border = table.border[block] != 0;
        for (std::uint32_t k = list.first[block] + bounds[0]; k < list.first[block] + bounds[1]; ++k) {
            p.fetch(list.ahead(block, k));
            add_particle(list.slot[k], base, border, sums);
        }
        Real* to = tile + tile_offset<Dim, width>(c) * node_reals;
        each_node<Dim, width>([&](int at, int i, int j, int k) {
            Real* q = to + at * node_reals;
            Pair::load(q).plus(sums[i + width * (j + width * k)]).store(q);
        });
    }

    /// What ghost nodes behind walls were given goes to the nodes that they follow.
    MORAINE_HD void fold_ghosts(int block, Real* tile) const {
        int base[Dim];
        for (int a = 0; a < Dim; ++a) base[a] = first_node<Shape>(table.position[block][a]);
        each_ghost(context.walls, base, side, [&](int ghost, int step) {
            for (int half = 0; half < 2; ++half) {
                Real* from = tile + ghost * node_reals + half * quad;
                Real* first = from + step * node_reals;
                Real* second = first + step * node_reals;
                const Q sums = Q::load(from);
                fma(Real(2), sums, Q::load(first)).store(first);
                fma(Real(-1), sums, Q::load(second)).store(second);
                Q::zero().store(from);
            }
        });
    }

    /// What one particle brings to every node of its stencil.
    struct Load {
        Pair carried;         ///< (m, q) at the stencil's first node, and -V sigma's column y
        Pair slope[Dim];      ///< change of (m, q) from node to node
        Pair along;           ///< the columns x,
        Pair last;            ///< and z
        Pair body_force;      ///< (m b, s)
        bool has_body_force;  ///< or s
    };

    MORAINE_HD void add_particle(std::uint32_t s, const int* base, bool border, Pair* sums) const {
        std::uint32_t slots[Factors::count];
        for (std::uint32_t& slot : slots) slot = s;
        Weights<Number, Dim, Shape> n = stencils<Factors, Shape>(context, p, slots);
        if constexpr (Affine && Shape::width > 2)
            for (int a = 0; border && a < Dim; ++a)
                fold_weights<Shape::width>(context.walls.ghosts(a, base[a], width), n.w[a], n.dw[a]);
        Real f[Dim];
        for (int a = 0; a < Dim; ++a) f[a] = Factors::number_of(n.f[a], 0);
        add_nodes(n, load_of(s, base, f), sums);
    }

    MORAINE_HD Load load_of(std::uint32_t s, const int* base, const Real* f) const {
        using std::fma;
        const Q none = Q::zero();
        const Real m = p.mass[s];
        Load load;
        Sym<Real, Dim> sigma = p.stress[s];
        const Real pressure = sigma.trace() * Real(1.0 / 3.0);
        const bool of_grid = grid_bulk && grid_bulk[p.body[s]] > Real(0);
        for (int a = 0; of_grid && a < 3; ++a) sigma[a] -= pressure;
        load.has_body_force = p.body_force || p.load_force || mean != NodeMean::none;
        if (load.has_body_force) {
            Q body_force = p.body_force ? Q::scaled(m, p.body_force[s]) : none;
            if (p.load_force) body_force = body_force + Q::scaled(Real(1), p.load_force[s]);
            if (mean != NodeMean::none) {
                const Real s_of_p = mean == NodeMean::volume
                                        ? (grid_bulk && !of_grid ? Real(0) : p.volume[s])
                                        : m * (pressure + gravity_pressure<Real, Dim>(context.gravity_slope, base, f));
                body_force = body_force + Q::of(Real(0), Real(0), Real(0), s_of_p);
            }
            load.body_force = Pair::of(none, body_force);
        }
        Q carried = Q::scaled_after(m, m, p.velocity[s]), traction[Dim];
        for (int b = 0; b < Dim; ++b) {
            Vec<Real, Dim> column;
            for (int a = 0; a < Dim; ++a) column[a] = sigma(a, b);
            traction[b] = Q::scaled(-p.volume[s], column);
            if (p.load_couple) {
                for (int a = 0; a < Dim; ++a) column[a] = p.load_couple[s](a, b);
                traction[b] = traction[b] + Q::scaled(Real(1), column);
            }
            if constexpr (Affine) {
                for (int a = 0; a < Dim; ++a) column[a] = p.affine[s](a, b) * cell;
                const Q slope = Q::scaled_after(Real(0), m, column);
                load.slope[b] = Pair::of(slope, none);
                carried = fma(-(f[b] + Shape::template reach<Real>), slope, carried);
            }
        }
        load.carried = Pair::of(carried, traction[1]);
        load.along = Pair::of(none, traction[0]);
        if constexpr (Dim == 3) load.last = Pair::of(none, traction[Dim - 1]);
        return load;
    }

    MORAINE_HD static void add_nodes(const Weights<Number, Dim, Shape>& n, const Load& load, Pair* sums) {
        constexpr int layers = Dim == 2 ? 1 : width;
        for (int k = 0; k < layers; ++k) {
            const Number wz = Dim == 2 ? Number(1) : n.w[Dim - 1][k];
            for (int j = 0; j < width; ++j) {
                const Number wyz = n.w[1][j] * wz;
                Pair both = load.carried;
                if constexpr (Affine) {
                    both = both.first_plus(Number(j), load.slope[1]);
                    if constexpr (Dim == 3) both = both.first_plus(Number(k), load.slope[Dim - 1]);
                }
                both = both.times(wyz, n.dw[1][j] * wz);
                if constexpr (Dim == 3) both = both.second_plus(n.w[1][j] * n.dw[Dim - 1][k], load.last);
                if (load.has_body_force) both = both.second_plus(wyz, load.body_force);
                const Pair along = load.along.times(wyz, wyz);
                Pair step;
                if constexpr (Affine) step = load.slope[0].times(wyz, wyz);
                for (int i = 0; i < width; ++i) {
                    Pair& to = sums[i + width * (j + width * k)];
                    to = to.plus(n.w[0][i], both).second_plus(n.dw[0][i], along);
                    if constexpr (Affine) both = both.first_plus(step);
                }
            }
        }
    }
};

}  // namespace moraine
