#pragma once
// Grid to particles: velocity, place, velocity gradient; then stress, by the scene's materials.
//
//   v_pic = sum_i w_ip v_i'        v_p <- a (v_p + sum_i w_ip dv_i) + (1 - a) v_pic     (a: share of FLIP)
//   x_p <- x_p + dt v_pic          dL = dt sum_i v_i' grad w_ip
//   C_p = grad v (TPIC), or sum_i w_ip v_i' (x_i - x_p)ᵀ / D  (APIC, D = sum w (x_i - x_p)^2 per axis; Jiang et al.
//   2015)
// What else a scene's physics does to a particle is its terms (terms/terms.hpp): light nodes, pressures, shifting.
//
// One team reads the nodes of one block into its scratch and goes through the list cell by cell.
// Along an axis whose ghost node was folded, APIC takes the gradient: there D tends to zero.
// `Stress` is called with batches of particles and their dL: on the host one call per material in
// the scene, so that a law is compiled once and not once per shape and transfer.

#include "core/grid/particle_update.hpp"
#include "core/particles/place_step.hpp"
#include "core/particles/stress.hpp"
#include "core/terms/box_term.hpp"
#include "core/terms/light_term.hpp"
#include "core/terms/means_term.hpp"
#include "core/terms/pressure_term.hpp"
#include "core/terms/shifting_term.hpp"
#include "core/terms/smoothing_term.hpp"
#include "core/terms/traction_term.hpp"
#include "core/terms/water_term.hpp"

namespace moraine {

/// The terms of the host, in their order. Smoothing comes before a cell's step, whose work is taken from the pressure;
/// boxes see a cell's dL, but not its mean.
template <class Real, int Dim>
using HostTerms = Terms<LightTerm<Real>, SmoothingTerm<Real>, PressureTerm<Real>, WaterTerm<Real, Dim>, BoxTerm,
                        TractionTerm, MeansTerm<Real>, ShiftingTerm<Real, Dim>>;

/// What a round of a scheme takes from the nodes.
template <class Real>
struct GatherRound {
    unsigned gather;  ///< bits of Gather
    bool tpic;        ///< C_p is the velocity gradient
    Real flip;        ///< share of FLIP [-]
    Real dt;          ///< [s]
};

/// What a gather says of own blocks, besides their particles' new states.
struct GatherNotes {
    std::uint16_t* moves;           ///< per list entry
    std::uint32_t* outgoing_count;  ///< particles that change block
    std::uint8_t* shuffled;         ///< any particle changed its cell
    BlockOutcome* outcome;
};

template <class Case, class Stress, class AllTerms = HostTerms<typename Case::Real, Case::dim>>
struct GridToParticles {
    using Real = typename Case::Real;
    using Shape = typename Case::Shape;
    using Q = Quad<Real>;
    using Cell = CellInWork<Case>;
    using State = typename AllTerms::template State<Case>;
    static constexpr int Dim = Case::dim, batch = Case::batch;

    struct Scratch {
        Q nodes[2 * Case::tile_nodes];
        Mat<Real, Dim> gradient[batch];
        std::uint32_t slot[batch];
        int filled;   ///< of the batch
        State terms;  ///< of the block
    };

    StencilContext<Real, Dim> context;
    ParticleView<Real, Dim> p;
    BlockTable<Dim> table;
    ListView<Dim> list;
    TileView<Real> grid;
    Stress stress;
    const std::int32_t* chosen;  ///< own blocks
    DomainEnds<Real, Dim> ends;
    GatherRound<Real> round;
    GatherNotes notes;
    AllTerms terms;

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int block = chosen[item];
        BlockOutcome out;
        notes.outgoing_count[block] = 0;
        notes.shuffled[block] = 0;
        if (list.count(block) > 0) {
            team.each(Case::tile_nodes, [&](int n) { load_node(block, n, scratch); });
            team.sync();
            if (Shape::width > 2 && table.border[block]) set_ghosts(block, scratch.nodes);
            scratch.filled = 0;
            terms.template each<hook_block, Case>(*this, scratch.terms,
                                                  [&](const auto& term, auto& state) MORAINE_INLINE {
                                                      term.at_block(*this, block, scratch.nodes, state);
                                                  });
            for (int c = 0; c < Block<Dim>::cells; ++c) gather_cell(block, c, scratch, out);
            flush(scratch, out);
        }
        notes.outcome[block] = out;
    }

    // What terms ask of a gather.

    MORAINE_HD bool takes_gradient() const { return (round.gather & gather_gradient) != 0; }
    MORAINE_HD std::size_t stored_node(int block, int n) const {
        return stored_tile_node<Case::width>(table, grid, block, n);
    }
    /// Of an array [tile][cell].
    template <class T>
    MORAINE_HD const T& cell_of(const T* all, const Cell& cell) const {
        return all[std::size_t(grid.tile_of[cell.block]) * Block<Dim>::cells + std::size_t(cell.number)];
    }

  private:
    MORAINE_HD void load_node(int block, int n, Scratch& scratch) const {
        const Real* from = grid.nodes + stored_node(block, n) * node_reals;
        scratch.nodes[2 * n] = Q::load(from);
        scratch.nodes[2 * n + 1] = Q::load(from + quad);
    }

    /// Ghost nodes behind walls follow the two nodes before them.
    MORAINE_HD void set_ghosts(int block, Q* nodes) const {
        int base[Dim];
        for (int a = 0; a < Dim; ++a) base[a] = first_node<Shape>(table.position[block][a]);
        each_ghost(context.walls, base, Case::side, [&](int ghost, int step) {
            for (int half = 0; half < 2; ++half) {
                const Q* first = nodes + 2 * (ghost + step) + half;
                nodes[2 * ghost + half] = fma(Real(-1), first[2 * step], Real(2) * first[0]);
            }
        });
    }

    MORAINE_HD Cell cell_in_work(int block, int c, const Scratch& scratch) const {
        const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (Block<Dim>::cells + 1) + c;
        Cell cell{block,
                  c,
                  list.first[block] + bounds[0],
                  list.first[block] + bounds[1],
                  scratch.nodes + 2 * tile_offset<Dim, Case::width>(c),
                  {},
                  {},
                  false,
                  {}};
        for (int a = 0; a < Dim; ++a) {
            cell.base[a] = first_node<Shape>(table.position[block][a]) + cell_coordinate<Dim>(c, a);
            cell.ghosts[a] = table.border[block] ? context.walls.ghosts(a, cell.base[a], Case::width) : 0u;
            cell.at_wall = cell.at_wall || cell.ghosts[a] != 0;
            cell.plain[a] = affine_is_gradient<Shape>(round.tpic, [&] { return cell.ghosts[a] != 0; });
        }
        return cell;
    }

    MORAINE_HD void gather_cell(int block, int c, Scratch& scratch, BlockOutcome& out) const {
        const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (Block<Dim>::cells + 1) + c;
        if (bounds[0] == bounds[1]) return;
        const Cell cell = cell_in_work(block, c, scratch);
        const bool whole = takes_gradient() && terms.template any<hook_after_cell>(*this);
        if (whole && unsigned(scratch.filled) + (cell.end - cell.begin) > unsigned(batch)) flush(scratch, out);
        const int first = scratch.filled;
        const auto gathered = [&](const auto& f) MORAINE_INLINE {
            each_gathered(cell, scratch.terms, [&](std::uint32_t, const auto& point) MORAINE_INLINE {
                Mat<Real, Dim> dL;
                take_increment(point.sums, dL);
                f(point.slot, dL);
            });
        };
        terms.template each<hook_cell, Case>(*this, scratch.terms, [&](const auto& term, auto& state) MORAINE_INLINE {
            term.at_cell(*this, cell, state, gathered);
        });
        each_gathered(cell, scratch.terms, [&](std::uint32_t k, const auto& point) MORAINE_INLINE {
            p.fetch_all(list.ahead(block, k));
            if (round.gather & gather_velocity) take_velocity(point);
            if (takes_gradient()) {
                take_rate(cell, point, scratch, out);
                if (scratch.filled == batch && !(whole && k + 1 == cell.end)) flush(scratch, out);
            }
            if (moves_particles(round.gather)) move(cell, k, point, scratch, out);
        });
        if (whole) close_cell(cell, first, scratch, out);
    }

    /// Calls f(list entry, point) for the particles of a cell, in order.
    template <class F>
    MORAINE_HD void each_gathered(const Cell& cell, State& state, const F& f) const {
        using T = typename Case::T;
        for (std::uint32_t k = cell.begin; k < cell.end; k += T::count) {
            std::uint32_t slots[T::count];  // the last one again where fewer are left
            for (int i = 0; i < T::count; ++i) slots[i] = list.slot[k + i < cell.end ? k + i : cell.end - 1];
            const auto n = stencils<T, Shape>(context, p, slots);
            auto sums = sum_nodes<Case::affine, T, Shape, Real, Dim>(n, cell.nodes, cell.plain, context.inverse_cell);
            for (int i = 0; i < T::count && k + i < cell.end; ++i) {
                const auto stencil_of = [&] { return part_of<T, Real, Dim, Shape>(n, i); };
                const PointInWork<Case, decltype(stencil_of)> point{p, slots[i], stencil_of,
                                                                    GatheredPart<T, Dim>(sums, i)};
                terms.template each<hook_rate, Case>(*this, state, [&](const auto& term, auto& own) MORAINE_INLINE {
                    term.on_rate(*this, cell, point, own);
                });
                f(k + i, point);
            }
        }
    }

    /// dL of the step, to where it stays: a copy would be loaded as a whole right after it is stored in parts.
    MORAINE_HD void take_increment(const GatheredPart<typename Case::T, Dim>& g, Mat<Real, Dim>& dL) const {
        for (int a = 0; a < Dim; ++a)
            for (int b = 0; b < Dim; ++b) dL(a, b) = round.dt * g.gradient(b)[a];
    }

    /// Puts a particle into the batch.
    template <class Point>
    MORAINE_HD void take_rate(const Cell& cell, const Point& point, Scratch& scratch, BlockOutcome& out) const {
        Mat<Real, Dim>& dL = scratch.gradient[scratch.filled];
        take_increment(point.sums, dL);
        terms.template each<hook_stress, Case>(*this, scratch.terms, [&](const auto& term, auto& state) MORAINE_INLINE {
            term.before_stress(*this, cell, point, dL, state, out);
        });
        scratch.slot[scratch.filled++] = point.slot;
    }

    /// The particles of a cell are the batch's from `first` on.
    MORAINE_HD void close_cell(const Cell& cell, int first, Scratch& scratch, BlockOutcome& out) const {
        terms.template each<hook_after_cell, Case>(
            *this, scratch.terms, [&](const auto& term, auto& state) MORAINE_INLINE {
                term.after_cell(*this, cell, scratch.slot + first, scratch.gradient + first, scratch.filled - first,
                                state);
            });
        if (scratch.filled == batch) flush(scratch, out);
    }

    template <class Point>
    MORAINE_HD void take_velocity(const Point& point) const {
        const std::uint32_t s = point.slot;
        const auto& g = point.sums;
        for (int a = 0; a < Dim; ++a)
            p.velocity[s][a] = blended_velocity(round.flip, p.velocity[s][a], g.change()[a], g.velocity()[a]);
        if constexpr (Case::affine)
            for (int a = 0; a < Dim; ++a)
                for (int b = 0; b < Dim; ++b) p.affine[s](a, b) = g.affine(b)[a];
    }

    MORAINE_HD void flush(Scratch& scratch, BlockOutcome& out) const {
        if (scratch.filled > 0) stress(p, scratch.slot, scratch.gradient, scratch.filled, round.dt, out);
        scratch.filled = 0;
    }

    /// Moves the particle of list entry k and notes where it is to be binned next.
    template <class Point>
    MORAINE_HD void move(const Cell& cell, std::uint32_t k, const Point& point, Scratch& scratch,
                         BlockOutcome& out) const {
        const int block = cell.block;
        Q velocity = Q::load(moving_velocity(round.gather, point.sums.velocity(), point.sums.change()));
        terms.template each<hook_velocity, Case>(*this, scratch.terms,
                                                 [&](const auto& term, auto& state) MORAINE_INLINE {
                                                     term.on_velocity(*this, cell, point, state, velocity);
                                                 });
        const PlaceStep<Real> step = advance_place(ends, table.position[block], table.border[block] != 0, velocity,
                                                   round.dt, context.inverse_cell, p.position[point.slot]);
        if (step.faults) out.fault(step.faults, p.id[point.slot]);
        if (double(step.moved) > out.moved) out.moved = double(step.moved);
        notes.moves[k] = step.move;
        if (move_code(step.move) != Block<Dim>::centre) ++notes.outgoing_count[block];
        if (changes_cell<Dim>(step.move, cell.number)) notes.shuffled[block] = 1;
    }
};

}  // namespace moraine
