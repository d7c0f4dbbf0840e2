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
#include "core/gather_sums.hpp"
#include "core/grid_views.hpp"
#include "core/light_cell.hpp"
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
    using Light = LightCell<Real, Dim, width>;
    using T = Together<Real, particles_together<Real>>;  ///< particles of a cell that are gathered together
    using Part = GatheredPart<T, Dim>;

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
        if (stiffness) light.least = least_mass<Dim, width>(nodes);
        if (averages && crowded) mean = mean_of_overfull(begin, end, nodes, plain, light);
        each_gathered(begin, end, nodes, plain,
                      [&](std::uint32_t k, std::uint32_t s, const auto& stencil_of, const Part& g) MORAINE_INLINE {
                          p.fetch_all(list.ahead(block, k));
                          if (stiffness) limit_acceleration(s, stencil_of, nodes, light, g);
                          if (gather & gather_velocity) take_velocity(s, g);
                          if (gather & gather_gradient) {
                              if (fluid && (!shifting || grid_bulk)) smooth(block, c, s, stencil_of, light.base, g);
                              take_increment(g, scratch.gradient[filled]);
                              if (grid_bulk) take_cell(block, c, s, scratch.gradient[filled], out);
                              if (p.log_stretch) stretch_box(s, scratch.gradient[filled], out);
                              if (averages && crowded) take_mean(mean, s, scratch.gradient[filled]);
                              scratch.slot[filled++] = s;
                              if (averages && k + 1 == end && !crowded) average(scratch, first, filled);
                              if (filled == batch) flush(scratch, filled, out);
                          }
                          if (moves_particles(gather)) {
                              Q velocity = Q::load(moving_velocity(gather, g.velocity(), g.change()));
                              if (shifting) add_shift(block, c, s, stencil_of, scratch, velocity);
                              move(block, s, k, c, velocity, border, out);
                          }
                      });
    }

    /// Calls f(list entry, slot, its stencil's maker, what it gathered) for the particles of a cell, in order.
    template <class F>
    MORAINE_HD void each_gathered(std::uint32_t begin, std::uint32_t end, const Q* nodes, const bool* plain,
                                  const F& f) const {
        for (std::uint32_t k = begin; k < end; k += T::count) {
            std::uint32_t slots[T::count];  // the last one again where fewer are left
            for (int i = 0; i < T::count; ++i) slots[i] = list.slot[k + i < end ? k + i : end - 1];
            const auto n = stencils<T, Shape>(context, p, slots);
            auto sums = sum_nodes<Affine, T, Shape, Real, Dim>(n, nodes, plain, context.inverse_cell);
            for (int i = 0; i < T::count && k + i < end; ++i) {
                f(
                    k + i, slots[i], [&] { return part_of<T, Real, Dim, Shape>(n, i); }, Part(sums, i));
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
        each_gathered(begin, end, nodes, plain,
                      [&](std::uint32_t, std::uint32_t s, const auto& stencil_of, const Part& g) MORAINE_INLINE {
                          if (stiffness) limit_acceleration(s, stencil_of, nodes, light, g);
                          Mat<Real, Dim> dL;
                          take_increment(g, dL);
                          add_to_mean(mean, s, dL);
                      });
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

    /// dL of the step, to where it stays: a copy would be loaded as a whole right after it is stored in parts.
    MORAINE_HD void take_increment(const Part& g, Mat<Real, Dim>& dL) const {
        for (int a = 0; a < Dim; ++a)
            for (int b = 0; b < Dim; ++b) dL(a, b) = dt * g.gradient(b)[a];
    }

    /// Takes from the gradient and C of a particle what its light nodes cannot bear.
    template <class Stencil>
    MORAINE_HD void limit_acceleration(std::uint32_t s, const Stencil& stencil_of, const Q* nodes, Light& light,
                                       const Part& g) const {
        const Stiffness<Real>& k = stiffness[p.body[s]];
        if (!light.at_wall && Real(2) * light.least >= k.full_mass) return;
        const W n = stencil_of();
        LightStencil<Real, Dim, width> in;
        for (int a = 0; a < Dim; ++a)
            for (int i = 0; i < width; ++i) in.w[a][i] = n.w[a][i], in.dw[a][i] = n.dw[a][i];
        fold_stencil<Shape, Affine>(light.ghosts, tpic, n.f, context.inverse_cell, in);
        if (!light.ready) weigh_nodes(nodes, light);
        Real full = p.mass[s] / p.volume[s];  // rho h^d
        for (int a = 0; a < Dim; ++a) full /= context.inverse_cell;
        Vec<Real, Dim> reaction = reactions(in, full, light);
        for (int b = 0; b < Dim; ++b) reaction[b] *= dt * dt * k.wave * p.volume[s] / p.mass[s];
        const LightShare<Real, Dim> share = light_share(limits, reaction, in.folded, k.dilation);
        if (share.whole) return;
        const auto taken = taken_gradients<Affine>(in, limits, share, [&](int at, int i, int j, int l) {
            const int index[3] = {light.base[0] + i, light.base[1] + j, Dim == 3 ? light.base[Dim - 1] + l : 0};
            return acceleration<Real, Dim>(context.walls, index, nodes[2 * at], nodes[2 * at + 1]);
        });
        for (int b = 0; b < Dim; ++b)
            for (int a = 0; a < Dim; ++a) {
                g.gradient(b)[a] += taken.seen(a, b);
                if constexpr (Affine) g.affine(b)[a] += taken.kept(a, b);
            }
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

    template <class Stencil>
    MORAINE_HD void smooth(int block, int c, std::uint32_t s, const Stencil& stencil_of, const int* base,
                           const Part& g) const {
        const FluidTerms<Real>& of = fluid[p.body[s]];
        if (!(of.smoothing > Real(0))) return;
        const Real head = grid_bulk ? cell_of(block, c).head : g.change()[quad - 1];
        const Real pressure = head - gravity_pressure<Real, Dim>(context.gravity_slope, base, stencil_of().f);
        smooth_pressure(smoothing_share(of.smoothing, dt), pressure, of.compliance, p.stress[s], p.ln_J[s]);
    }

    /// Adds the shift of a particle in cell c to the velocity that moves it.
    template <class Stencil>
    MORAINE_HD void add_shift(int block, int c, std::uint32_t s, const Stencil& stencil_of, const Scratch& scratch,
                              Q& velocity) const {
        const Real shifts = fluid[p.body[s]].shifting;
        if (!(shifts > Real(0))) return;
        const Real* excess = scratch.excess + tile_offset<Dim, width>(c);
        const Vec<Real, Dim> gradient = gradient_of_excess<Shape>(stencil_of(), excess);
        const Real h = Real(1) / context.inverse_cell, most = Real(0.5) * h * h / shifts;
        Vec<Real, Dim> shift = shift_by(shifts, grid_bulk && most < dt ? most : dt, h, gradient);
        if (table.border[block]) {
            Vec<Real, Dim> move;
            for (int a = 0; a < Dim; ++a) move[a] = dt * velocity[a] * context.inverse_cell;
            keep_from_ends(shifting->ends, table.position[block], p.position[s], move, shift);
        }
        velocity = velocity + Q::scaled(Real(1) / dt, shift);
    }

    MORAINE_HD void take_velocity(std::uint32_t s, const Part& g) const {
        for (int a = 0; a < Dim; ++a)
            p.velocity[s][a] = blended_velocity(flip, p.velocity[s][a], g.change()[a], g.velocity()[a]);
        if constexpr (Affine)
            for (int a = 0; a < Dim; ++a)
                for (int b = 0; b < Dim; ++b) p.affine[s](a, b) = g.affine(b)[a];
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
