#pragma once
// Grid to particles: velocity, place, velocity gradient; then stress, by the scene's materials.
//
//   v_pic = sum_i w_ip v_i'        v_p <- a (v_p + sum_i w_ip dv_i) + (1 - a) v_pic     (a: share of FLIP)
//   x_p <- x_p + dt v_pic          dL = dt sum_i v_i' grad w_ip
//   C_p = grad v (TPIC), or sum_i w_ip v_i' (x_i - x_p)ᵀ / D  (APIC, D = sum w (x_i - x_p)^2 per axis; Jiang et al.
//   2015)
// Pressures of fluids are smoothed, and particles shifted (pressure_smoothing.hpp, particle_shifting.hpp).
// What this step adds to dL and C is limited where a particle's nodes hold little mass (light_nodes.hpp).
//
// One team reads the nodes of one block into its scratch and goes through the list cell by cell.
// Along an axis whose ghost node was folded, APIC takes the gradient: there D tends to zero.
// Where a material takes its volumetric part from the cell (volumetric.hpp), a cell's particles stay in one batch.
// `Stress` is called with batches of particles and their dL: on the host one call per material in
// the scene, so that a law is compiled once and not once per shape and transfer.

#include "core/cell_kernels.hpp"
#include "core/grid_views.hpp"
#include "core/light_stencil.hpp"
#include "core/particle_shifting.hpp"
#include "core/particle_update.hpp"
#include "core/place_step.hpp"
#include "core/quad.hpp"
#include "core/stencil.hpp"
#include "core/stress.hpp"
#include "core/volumetric.hpp"

namespace moraine {

template <class Real, int Dim, class Shape, bool Affine, class Stress>
struct GridToParticles {
    static constexpr int width = Shape::width;
    static constexpr int side = tile_side(width);
    static constexpr int tile_nodes = power<Dim>(side);
    static constexpr int batch = 64;
    using Q = Quad<Real>;
    using W = Weights<Real, Dim, Shape>;

    struct Scratch {
        Q nodes[2 * tile_nodes];
        Mat<Real, Dim> gradient[batch];
        std::uint32_t slot[batch];
        Real excess[tile_nodes];  ///< e_i, in steps that shift (particle_shifting.hpp)
    };

    StencilContext<Real, Dim> context;
    ParticleView<Real, Dim> p;
    BlockTable<Dim> table;
    ListView<Dim> list;
    TileView<Real> grid;
    Stress stress;
    const std::int32_t* chosen;    ///< own blocks
    const std::uint8_t* averaged;  ///< by body: takes its volumetric part from the cell; null: none does
    DomainEnds<Real, Dim> ends;
    unsigned gather;                   ///< bits of Gather
    bool tpic;                         ///< C_p is the velocity gradient
    Real flip;                         ///< share of FLIP [-]
    Real dt;                           ///< [s]
    std::uint16_t* moves;              ///< per list entry
    std::uint32_t* outgoing_count;     ///< own blocks: particles that change block
    std::uint8_t* shuffled;            ///< own blocks: any particle changed its cell
    BlockOutcome* outcome;             ///< own blocks
    const Stiffness<Real>* stiffness;  ///< by body; null: nothing is limited
    ReactionLimits<Real> limits;
    const FluidTerms<Real>* fluid;        ///< by body; null: pressures are not smoothed, particles not shifted
    const Shifting<Real, Dim>* shifting;  ///< null: not in this step
    const Real* grid_bulk;                ///< by body: K where the pressure is the grid's, else 0; null: nowhere [Pa]
    CellViews<Real, Dim> cells;           ///< of the grid's pressure

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int block = chosen[item];
        BlockOutcome out;
        outgoing_count[block] = 0;
        shuffled[block] = 0;
        if (list.count(block) > 0) {
            team.each(tile_nodes, [&](int n) { load_node(block, n, scratch); });
            team.sync();
            if (Shape::width > 2 && table.border[block]) set_ghosts(block, scratch.nodes);
            int filled = 0;
            if (shifting) {
                int base[Dim];
                for (int a = 0; a < Dim; ++a) base[a] = first_node<Shape>(table.position[block][a]);
                find_excess<Shape>(
                    *shifting, context.walls, base, [&](int n) { return volume_at(block, n, scratch); },
                    scratch.excess);
            }
            for (int c = 0; c < Block<Dim>::cells; ++c) gather_cell(block, c, scratch, filled, out);
            flush(scratch, filled, out);
        }
        outcome[block] = out;
    }

  private:
    /// What a cell's particles share where nodes may be light.
    struct Light {
        int base[Dim];                    ///< first node of the stencil
        unsigned ghosts[Dim];             ///< of the stencil (Walls::ghosts)
        bool at_wall;                     ///< some ghost is folded
        Real least;                       ///< mass of a node [kg]
        bool ready;                       ///< the next ones are known
        Real around;                      ///< mass of all nodes but those behind walls [kg]
        Real inverse[power<Dim>(width)];  ///< of their masses [1/kg]
    };

    MORAINE_HD std::size_t stored_node(int block, int n) const {
        return stored_tile_node<width>(table, grid, block, n);
    }

    MORAINE_HD void load_node(int block, int n, Scratch& scratch) const {
        const Real* from = grid.nodes + stored_node(block, n) * node_reals;
        scratch.nodes[2 * n] = Q::load(from);
        scratch.nodes[2 * n + 1] = Q::load(from + quad);
    }

    /// v_i / h^d.
    MORAINE_HD Real volume_at(int block, int n, const Scratch& scratch) const {
        if (cells.held) return cells.held[stored_node(block, n)].filling;
        return scratch.nodes[2 * n][quad - 1] * scratch.nodes[2 * n + 1][quad - 1] * shifting->inverse_volume;
    }

    /// Ghost nodes behind walls follow the two nodes before them.
    MORAINE_HD void set_ghosts(int block, Q* nodes) const {
        int base[Dim];
        for (int a = 0; a < Dim; ++a) base[a] = first_node<Shape>(table.position[block][a]);
        each_ghost(context.walls, base, side, [&](int ghost, int step) {
            for (int half = 0; half < 2; ++half) {
                const Q* first = nodes + 2 * (ghost + step) + half;
                nodes[2 * ghost + half] = fma(Real(-1), first[2 * step], Real(2) * first[0]);
            }
        });
    }

    MORAINE_HD void gather_cell(int block, int c, Scratch& scratch, int& filled, BlockOutcome& out) const {
        const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (Block<Dim>::cells + 1) + c;
        if (bounds[0] == bounds[1]) return;
        const bool border = table.border[block] != 0;
        bool plain[Dim];  // C is the velocity gradient
        Light light;
        light.ready = light.at_wall = false;
        for (int a = 0; a < Dim; ++a) {
            light.base[a] = first_node<Shape>(table.position[block][a]) + cell_coordinate<Dim>(c, a);
            light.ghosts[a] = border ? context.walls.ghosts(a, light.base[a], width) : 0u;
            light.at_wall = light.at_wall || light.ghosts[a] != 0;
            plain[a] = affine_is_gradient<Shape>(tpic, [&] { return light.ghosts[a] != 0; });
        }
        const Q* nodes = scratch.nodes + 2 * tile_offset<Dim, width>(c);
        const std::uint32_t begin = list.first[block] + bounds[0], end = list.first[block] + bounds[1];
        const bool averages = averaged && (gather & gather_gradient), crowded = end - begin > unsigned(batch);
        if (averages && unsigned(filled) + (end - begin) > unsigned(batch)) flush(scratch, filled, out);
        const int first = filled;
        VolumetricMean<Real> mean;
        light.around = Real(0);
        light.least = stiffness ? least_mass(nodes) : Real(0);
        if (averages && crowded) mean = mean_of_overfull(begin, end, nodes, plain, light);
        for (std::uint32_t k = begin; k < end; ++k) {
            p.fetch_all(list.ahead(block, k));
            const std::uint32_t s = list.slot[k];
            const W n = stencil<Real, Dim, Shape>(context, p, s);
            Gathered g = sum_nodes(n, nodes, plain);
            if (stiffness) limit_acceleration(s, n, nodes, light, g);
            if (gather & gather_velocity) take_velocity(s, g);
            if (gather & gather_gradient) {
                if (fluid && (!shifting || grid_bulk)) smooth(block, c, s, n, light.base, g);
                scratch.gradient[filled] = increment_of(g);
                if (grid_bulk) take_cell(block, c, s, scratch.gradient[filled], out);
                if (p.log_stretch) stretch_box(s, scratch.gradient[filled], out);
                if (averages && crowded) take_mean(mean, s, scratch.gradient[filled]);
                scratch.slot[filled++] = s;
                if (averages && k + 1 == end && !crowded) average(scratch, first, filled);
                if (filled == batch) flush(scratch, filled, out);
            }
            if (moves_particles(gather)) {
                Q velocity = moving_velocity(gather, g.velocity, g.change);
                if (shifting) add_shift(block, c, s, n, scratch, velocity);
                move(block, s, k, c, velocity, border, out);
            }
        }
    }

    /// Gives the particles first, ..., filled - 1 of the batch, which are those of one cell, their common means.
    MORAINE_HD void average(Scratch& scratch, int first, int filled) const {
        VolumetricMean<Real> mean;
        for (int k = first; k < filled; ++k) add_to_mean(mean, scratch.slot[k], scratch.gradient[k]);
        mean.finish();
        for (int k = first; k < filled; ++k) take_mean(mean, scratch.slot[k], scratch.gradient[k]);
    }

    /// The means of a cell with more particles than a batch holds: they are gathered twice.
    MORAINE_HD VolumetricMean<Real> mean_of_overfull(std::uint32_t begin, std::uint32_t end, const Q* nodes,
                                                     const bool* plain, Light& light) const {
        VolumetricMean<Real> mean;
        for (std::uint32_t k = begin; k < end; ++k) {
            const W n = stencil<Real, Dim, Shape>(context, p, list.slot[k]);
            Gathered g = sum_nodes(n, nodes, plain);
            if (stiffness) limit_acceleration(list.slot[k], n, nodes, light, g);
            add_to_mean(mean, list.slot[k], increment_of(g));
        }
        mean.finish();
        return mean;
    }

    MORAINE_HD void add_to_mean(VolumetricMean<Real>& mean, std::uint32_t s, const Mat<Real, Dim>& dL) const {
        if (averaged[p.body[s]]) mean.add(p.mass[s], trace(dL), p.stress[s].trace());
    }

    MORAINE_HD void take_mean(const VolumetricMean<Real>& mean, std::uint32_t s, Mat<Real, Dim>& dL) const {
        if (!averaged[p.body[s]]) return;
        set_trace(dL, mean.rate);
        set_trace(p.stress[s], mean.stress);
    }

    struct Gathered {
        Q velocity;       ///< sum w v'
        Q change;         ///< sum w dv
        Q gradient[Dim];  ///< sum v' dw/dx_b, per axis b
        Q affine[Dim];    ///< columns of C
    };

    /// dL of the step.
    MORAINE_HD Mat<Real, Dim> increment_of(const Gathered& g) const { return tensor_of<Dim>(dt, g.gradient); }

    static MORAINE_HD Gathered sum_nodes_plain(const W& n, const Q* nodes, const Real (*slope)[width], Gathered g) {
        constexpr int layers = Dim == 2 ? 1 : width;
        for (int k = 0; k < layers; ++k)
            for (int j = 0; j < width; ++j) {
                const Real wz = Dim == 2 ? Real(1) : n.w[Dim - 1][k];
                const Real wyz = n.w[1][j] * wz;
                const Real dyz = n.dw[1][j] * wz;
                const Real ydz = Dim == 2 ? Real(0) : n.w[1][j] * n.dw[Dim - 1][k];
                const Q* row = nodes + 2 * (side * (j + side * k));
                Q across = Q::zero(), along = Q::zero(), change = Q::zero(), lever = Q::zero();
                for (int i = 0; i < width; ++i) {
                    const Q& v = row[2 * i];
                    across = fma(n.w[0][i], v, across);
                    along = fma(n.dw[0][i], v, along);
                    change = fma(n.w[0][i], row[2 * i + 1], change);
                    if constexpr (Affine) lever = fma(slope[0][i], v, lever);
                }
                g.change = fma(wyz, change, g.change);
                g.gradient[0] = fma(wyz, along, g.gradient[0]);
                if constexpr (Affine) g.affine[0] = fma(wyz, lever, g.affine[0]);
                g.velocity = fma(wyz, across, g.velocity);
                g.gradient[1] = fma(dyz, across, g.gradient[1]);
                if constexpr (Dim == 3) g.gradient[Dim - 1] = fma(ydz, across, g.gradient[Dim - 1]);
                if constexpr (Affine) {
                    g.affine[1] = fma(slope[1][j] * wz, across, g.affine[1]);
                    if constexpr (Dim == 3)
                        g.affine[Dim - 1] = fma(n.w[1][j] * slope[Dim - 1][k], across, g.affine[Dim - 1]);
                }
            }
        return g;
    }

    MORAINE_HD Gathered sum_nodes(const W& n, const Q* nodes, const bool* plain) const {
        Gathered g;
        g.velocity = g.change = Q::zero();
        for (int a = 0; a < Dim; ++a) g.gradient[a] = g.affine[a] = Q::zero();
        if constexpr (Affine) {
            Real slope[Dim][width];
            for (int a = 0; a < Dim; ++a)
                affine_levers<Shape>(n.f[a], n.w[a], n.dw[a], context.inverse_cell, plain[a], slope[a]);
            return sum_nodes_plain(n, nodes, slope, g);
        } else {
            return sum_nodes_plain(n, nodes, nullptr, g);
        }
    }

    /// The least mass of the stencil's nodes [kg].
    static MORAINE_HD Real least_mass(const Q* nodes) {
        Real least = nodes[0][quad - 1];
        each_node<Dim, width>([&](int at, int, int, int) {
            const Real m = nodes[2 * at][quad - 1];
            if (m < least) least = m;
        });
        return least;
    }

    /// Takes from the gradient and C of a particle what its light nodes cannot bear.
    MORAINE_HD void limit_acceleration(std::uint32_t s, const W& n, const Q* nodes, Light& light, Gathered& g) const {
        const Stiffness<Real>& k = stiffness[p.body[s]];
        if (!light.at_wall && Real(2) * light.least >= k.full_mass) return;
        LightStencil<Real, Dim, width> in;
        for (int a = 0; a < Dim; ++a)
            for (int i = 0; i < width; ++i) in.w[a][i] = n.w[a][i], in.dw[a][i] = n.dw[a][i];
        fold_stencil<Shape, Affine>(light.ghosts, tpic, n.f, context.inverse_cell, in);
        if (!light.ready) weigh_nodes(nodes, light);
        Real full = p.mass[s] / p.volume[s];  // rho h^d
        for (int a = 0; a < Dim; ++a) full /= context.inverse_cell;
        Vec<Real, Dim> reaction = reactions(
            in, light.around, full,
            [&](int, int i, int j, int l) { return light.inverse[i + width * (j + width * l)]; },
            [&](int at, int b) { return moves_along<Real, Dim>(nodes[2 * at], b); });
        for (int b = 0; b < Dim; ++b) reaction[b] *= dt * dt * k.wave * p.volume[s] / p.mass[s];
        const LightShare<Real, Dim> share = light_share(limits, reaction, in.folded, k.dilation);
        if (share.whole) return;
        const auto taken = taken_gradients<Affine>(in, limits, share, [&](int at, int i, int j, int l) {
            const int index[3] = {light.base[0] + i, light.base[1] + j, Dim == 3 ? light.base[Dim - 1] + l : 0};
            return acceleration<Real, Dim>(context.walls, index, nodes[2 * at], nodes[2 * at + 1]);
        });
        for (int b = 0; b < Dim; ++b)
            for (int a = 0; a < Dim; ++a) g.gradient[b][a] += taken.seen(a, b), g.affine[b][a] += taken.kept(a, b);
    }

    /// A cell's masses, once for its particles.
    MORAINE_HD void weigh_nodes(const Q* nodes, Light& light) const {
        light.around = Real(0);
        light.ready = true;
        int n = 0;
        each_node<Dim, width>([&](int at, int i, int j, int k) {
            const Real m = is_inside<Dim>(light.ghosts, i, j, k) ? nodes[2 * at][quad - 1] : Real(0);
            light.around += m;
            light.inverse[n++] = m > Real(0) ? Real(1) / m : Real(0);
        });
    }

    MORAINE_HD const CellPressure<Real>& cell_of(int block, int c) const {
        return cells.cell[std::size_t(grid.tile_of[block]) * Block<Dim>::cells + std::size_t(c)];
    }

    /// The volumetric part of the step is that of the cell.
    MORAINE_HD void take_cell(int block, int c, std::uint32_t s, Mat<Real, Dim>& dL, BlockOutcome& out) const {
        Real square = Real(0);
        for (int a = 0; a < Dim; ++a) square += p.velocity[s][a] * p.velocity[s][a];
        if (double(square) > out.square_speed) out.square_speed = double(square);
        const Real bulk = grid_bulk[p.body[s]];
        if (!(bulk > Real(0))) return;
        const CellPressure<Real>& cell = cell_of(block, c);
        const Real borne = borne_share(cell.loose ? cell.bulk : Real(0), bulk);
        const Real increment = taken_increment(cell.increment, increment_in_tension(cell), borne);
        const Real step = bulk * increment;
        const Real before = p.stress[s].trace() * Real(1.0 / 3.0);
        out.work += double(p.volume[s]) * double(before + Real(0.5) * step) * double(increment);
        for (int a = 0; a < 3; ++a) p.stress[s][a] += step;
        Real cubic;
        dL = isochoric_increment(dL, cubic);
        p.ln_J[s] += increment - cubic;
    }

    MORAINE_HD void smooth(int block, int c, std::uint32_t s, const W& n, const int* base, const Gathered& g) const {
        const FluidTerms<Real>& of = fluid[p.body[s]];
        if (!(of.smoothing > Real(0))) return;
        const Real head = grid_bulk ? cell_of(block, c).head : g.change[quad - 1];
        const Real pressure = head - gravity_pressure<Real, Dim>(context.gravity_slope, base, n.f);
        smooth_pressure(smoothing_share(of.smoothing, dt), pressure, of.compliance, p.stress[s], p.ln_J[s]);
    }

    /// Adds the shift of a particle in cell c to the velocity that moves it.
    MORAINE_HD void add_shift(int block, int c, std::uint32_t s, const W& n, const Scratch& scratch,
                              Q& velocity) const {
        const Real shifts = fluid[p.body[s]].shifting;
        if (!(shifts > Real(0))) return;
        const Real* excess = scratch.excess + tile_offset<Dim, width>(c);
        const Vec<Real, Dim> gradient = gradient_of_excess<Shape>(n, excess);
        const Real h = Real(1) / context.inverse_cell, most = Real(0.5) * h * h / shifts;
        Vec<Real, Dim> shift = shift_by(shifts, grid_bulk && most < dt ? most : dt, h, gradient);
        if (table.border[block]) {
            Vec<Real, Dim> move;
            for (int a = 0; a < Dim; ++a) move[a] = dt * velocity[a] * context.inverse_cell;
            keep_from_ends(shifting->ends, table.position[block], p.position[s], move, shift);
        }
        velocity = velocity + Q::scaled(Real(1) / dt, shift);
    }

    MORAINE_HD void take_velocity(std::uint32_t s, const Gathered& g) const {
        for (int a = 0; a < Dim; ++a)
            p.velocity[s][a] = blended_velocity(flip, p.velocity[s][a], g.change[a], g.velocity[a]);
        if constexpr (Affine) p.affine[s] = tensor_of<Dim>(Real(1), g.affine);
    }

    MORAINE_HD void stretch_box(std::uint32_t s, const Mat<Real, Dim>& dL, BlockOutcome& out) const {
        bool held = false;
        for (int a = 0; a < Dim; ++a) {
            p.log_stretch[s][a] = advanced_stretch(p.log_stretch[s][a], dL(a, a));
            held = held || stretched_half(context.half_size[p.body[s]][a], p.log_stretch[s][a]) > Real(0.5);
        }
        if (held) ++out.clamped;
    }

    MORAINE_HD void flush(Scratch& scratch, int& filled, BlockOutcome& out) const {
        if (filled > 0) stress(p, scratch.slot, scratch.gradient, filled, dt, out);
        filled = 0;
    }

    /// Moves the particle of list entry k and notes where it is to be binned next.
    MORAINE_HD void move(int block, std::uint32_t s, std::uint32_t k, int from, const Q& velocity, bool border,
                         BlockOutcome& out) const {
        const PlaceStep<Real> step =
            advance_place(ends, table.position[block], border, velocity, dt, context.inverse_cell, p.position[s]);
        if (step.faults) out.fault(step.faults, p.id[s]);
        if (double(step.moved) > out.moved) out.moved = double(step.moved);
        moves[k] = step.move;
        if (move_code(step.move) != Block<Dim>::centre) ++outgoing_count[block];
        if (changes_cell<Dim>(step.move, from)) shuffled[block] = 1;
    }
};

}  // namespace moraine
