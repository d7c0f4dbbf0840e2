#pragma once
// Nodes: from sums to velocities.
//
//   v_i = q_i / m_i,   v_i' = v_i + dt (f_i / m_i + g) , then structures (contact.hpp), damping, walls
//   left for the gather: v_i' and dv_i = v_i' - v_i; in the quads' idle lanes m_i and s_i / m_i (NodeMean)
//
// A node is +0 plus its tiles in the order of the offset delta, never of keys or ranks, so that an
// absent tile and a zero tile are the same and all copies of a node are updated identically. Local
// non-viscous damping follows Cundall (1987): a fraction of |f| against the velocity. A node that a structure touches
// is not damped: |f| there is a load that the structure bears, and all of it shall be seen in its force.
//
// FMPM(k) (Nairn and Hammerquist 2021) puts the full mass matrix M for the lumped one m by k terms of a series:
//   v(k) = sum_{l=1..k} v_l,    v_1 = v_i',    v_l+1 = v_l - m^-1 M v_l,    M = S^T diag(m_p) S
// M v_l is what the nodes sum when particles have the velocity S v_l, so that a term is a round of its own. Terms add
// no momentum; walls and structures act on the sum so far, and what they give it is counted like any impulse.
//
// Nodes with less than `mass_cutoff` take no part: their velocity would be a ratio of roundings.
// Impulses of walls and damping are summed exactly, each node by the owner of the first occupied
// block c - delta, in offset order, whose tile covers it.

#include "core/contact.hpp"
#include "core/exact_sum.hpp"
#include "core/grid_views.hpp"
#include "core/quad.hpp"
#include "core/walls.hpp"

namespace moraine {

/// What a round asks of the nodes.
enum class NodeTask {
    solve,     ///< v' and dv from all sums
    velocity,  ///< v of the momentum, before the forces (USF); the former v' moves to the second quad
    again,     ///< the same after the forces (MUSL): what they press against a wall with friction stays there
    begin,     ///< v_1 = v' of a series, and the sum so far
    extend,    ///< v_l+1 from v_l and the momentum of S v_l, and the sum so far
    conclude,  ///< the sum, with its last term
};

/// Whether forces act.
MORAINE_HD constexpr bool solves(NodeTask task) {
    return task == NodeTask::solve || task == NodeTask::begin;
}
/// Whether the particles keep what walls and structures give the nodes.
MORAINE_HD constexpr bool counts(NodeTask task) {
    return task != NodeTask::velocity && task != NodeTask::again;
}
/// Whether the node's values of the round before are needed.
MORAINE_HD constexpr bool remembers(NodeTask task) {
    return !solves(task);
}

/// What all nodes of a round share.
template <class Real, int Dim>
struct NodeRound {
    NodeTask task;
    Real dt;                 ///< [s]
    Vec<Real, Dim> gravity;  ///< [m/s2]
    Real damping;            ///< [-]
    Real mass_cutoff;        ///< [kg]
};

/// Velocities of a node [m/s]: before the round, by forces and gravity alone, and with damping and walls.
template <class Real, int Dim>
struct NodeMotion {
    Vec<Real, Dim> start, trial, end;

    /// What damping and walls gave the node [kg m/s].
    MORAINE_HD double impulse(Real mass, int a) const { return double(mass) * (double(end[a]) - double(trial[a])); }
};

/// A node's quads, as a round leaves them.
template <class Real, int Dim>
struct NodeValues {
    Vec<Real, Dim> first, second;
};

/// What a round leaves at a node that had the values `former`.
template <class Real, int Dim>
MORAINE_HD NodeValues<Real, Dim> values_after(NodeTask task, const NodeMotion<Real, Dim>& motion,
                                              const NodeValues<Real, Dim>& former) {
    NodeValues<Real, Dim> now{motion.end, motion.end};
    for (int a = 0; a < Dim; ++a) {
        if (task == NodeTask::solve) now.second[a] = motion.end[a] - motion.start[a];
        if (!counts(task)) now.second[a] = former.first[a];
        if (task == NodeTask::extend) now.first[a] = motion.end[a] - former.second[a];
    }
    return now;
}

/// Takes the damping of one round from v.
template <class Real, int Dim>
MORAINE_HD void damp_node(const NodeRound<Real, Dim>& round, const Quad<Real>& force, Real inverse, Vec<Real, Dim>& v) {
    using std::fabs;
    for (int a = 0; a < Dim; ++a) {
        const Real brake = round.damping * round.dt * fabs(force[a] * inverse + round.gravity[a]);
        v[a] -= v[a] > Real(0) ? brake : (v[a] < Real(0) ? -brake : Real(0));
    }
}

/// Of a node that no structure is near.
struct Untouched {
    template <class Velocity>
    MORAINE_HD bool operator()(Velocity&) const {
        return false;
    }
};

/// The formula: from a node's sums (m, q) and (f, 0) to its velocities. former: its values of the round before, where
/// the task remembers them. `node`: its index; null where no wall is near. touch(v) applies the structures and says
/// whether one touches.
template <class Real, int Dim, class Touch = Untouched>
MORAINE_HD NodeMotion<Real, Dim> move_node(const NodeRound<Real, Dim>& round, const Walls<Real, Dim>& walls,
                                           const Quad<Real>& sums, const Quad<Real>& force,
                                           const NodeValues<Real, Dim>& former, const int* node,
                                           const Touch& touch = {}) {
    NodeMotion<Real, Dim> motion;
    motion.start = motion.trial = motion.end = zero_vec<Real, Dim>();
    const Real m = sums[0];
    if (!(m > round.mass_cutoff)) return motion;
    const Real inverse = Real(1) / m;
    for (int a = 0; a < Dim; ++a) motion.start[a] = sums[1 + a] * inverse;
    Vec<Real, Dim> v = motion.start;
    if (solves(round.task))
        for (int a = 0; a < Dim; ++a) v[a] += round.dt * (force[a] * inverse + round.gravity[a]);
    else if (counts(round.task))
        for (int a = 0; a < Dim; ++a) v[a] = former.second[a] + (former.first[a] - motion.start[a]);
    motion.trial = v;
    const bool touched = touch(v);
    if (round.damping > Real(0) && solves(round.task) && !touched) damp_node(round, force, inverse, v);
    if (node && round.task == NodeTask::again) walls.hold(node, former.first, v);
    if (node) walls.constrain(node, v);
    motion.end = v;
    return motion;
}

/// One instance for scenes with structures, one for the others.
template <class Real, int Dim, bool Contact = false>
struct SolveNodes {
    struct Scratch {
        Quad<Real> sums[2 * Block<Dim>::cells];
        std::int32_t counted_by[Block<Dim>::cells];  ///< first occupied source of the node, own or ghost; -1 none
    };

    Walls<Real, Dim> walls;
    BlockTable<Dim> table;
    TileView<Real> grid;
    const std::int32_t* chosen;  ///< node blocks to solve
    int width;
    int origin;
    NodeRound<Real, Dim> round;
    Quantum quantum;
    ExactSum* impulse;  ///< node blocks x Dim: impulse of walls and damping of this step [kg m/s]
    ContactField<Dim> contact = {};
    GapTiles gaps = {};

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int c = chosen[item];
        for (int a = 0; a < Dim; ++a) impulse[item * Dim + a] = ExactSum{};
        if (grid.node_of[c] < 0) return;
        const bool border = table.node_border[c] != 0;
        const bool near = structure_near(c);
        team.each(Block<Dim>::cells, [&](int n) {
            scratch.sums[2 * n] = scratch.sums[2 * n + 1] = Quad<Real>::zero();
            scratch.counted_by[n] = -1;
        });
        team.sync();
        for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
            const int source = table.source[c * Block<Dim>::corners + delta];
            const int tile = source < 0 ? -1 : grid.tile_of[source];
            if (tile < 0) continue;
            team.each(Block<Dim>::cells, [&](int n) { add_tile_node(n, delta, source, tile, scratch); });
            team.sync();
        }
        team.each(Block<Dim>::cells, [&](int n) { finish(c, item, n, border, near, scratch); });
    }

  private:
    MORAINE_HD void add_tile_node(int n, int delta, int source, int tile, Scratch& scratch) const {
        const int at = tile_node<Dim>(n, delta, width);
        if (at < 0) return;
        const Real* from = grid.tiles + (std::size_t(tile) * power<Dim>(tile_side(width)) + at) * node_reals;
        scratch.sums[2 * n] = scratch.sums[2 * n] + Quad<Real>::load(from);
        scratch.sums[2 * n + 1] = scratch.sums[2 * n + 1] + Quad<Real>::load(from + quad);
        if (scratch.counted_by[n] < 0) scratch.counted_by[n] = source;
    }

    static MORAINE_HD int cell_coordinate_of(int n, int axis) { return (n >> (2 * axis)) & 3; }

    /// Other node blocks look at no structure.
    MORAINE_HD bool structure_near(int c) const {
        bool near = false;
        if constexpr (Contact) {
            int lowest[Dim];
            for (int a = 0; a < Dim; ++a) lowest[a] = 4 * table.node_position[c][a] - origin;
            for (int k = 0; k < contact.count && !near; ++k) near = is_near(contact, contact.structure[k], lowest);
        }
        return near;
    }

    MORAINE_HD void finish(int c, int item, int n, bool border, bool near, Scratch& scratch) const {
        Real* out = grid.nodes + (std::size_t(grid.node_of[c]) * Block<Dim>::cells + n) * node_reals;
        const Quad<Real>& sums = scratch.sums[2 * n];
        const bool counted = counts(round.task) && scratch.counted_by[n] < table.own;
        int node[Dim];
        NodeValues<Real, Dim> former{};
        for (int a = 0; a < Dim; ++a) {
            node[a] = 4 * table.node_position[c][a] - origin + cell_coordinate_of(n, a);
            if (remembers(round.task)) former.first[a] = out[a], former.second[a] = out[quad + a];
        }
        NodeMotion<Real, Dim> motion;
        Vec<double, Dim> given = zero_vec<double, Dim>();  // to structures
        if constexpr (Contact) {
            motion =
                move_node(round, walls, sums, scratch.sums[2 * n + 1], former, border ? node : nullptr, [&](auto& v) {
                    return near &&
                           touch_structures(
                               contact, node, sums[0], round.dt, counted, quantum,
                               [&](int k) { return gap_at_node(gaps, table, grid.tile_of, width, c, n, k); }, v, given);
                });
        } else {
            motion = move_node(round, walls, sums, scratch.sums[2 * n + 1], former, border ? node : nullptr);
        }
        if ((border || round.damping > Real(0)) && counted)
            for (int a = 0; a < Dim; ++a) {
                double impulse_of_node = motion.impulse(sums[0], a);
                if constexpr (Contact) impulse_of_node += given[a];
                impulse[item * Dim + a].add(quantum.of(impulse_of_node));
            }
        const NodeValues<Real, Dim> now = values_after(round.task, motion, former);
        for (int a = 0; a < Dim; ++a) out[a] = now.first[a], out[quad + a] = now.second[a];
        for (int a = Dim; a < quad; ++a) out[a] = out[quad + a] = Real(0);
        out[quad - 1] = sums[0];
        if (sums[0] > round.mass_cutoff) out[2 * quad - 1] = scratch.sums[2 * n + 1][quad - 1] / sums[0];
    }
};

}  // namespace moraine
