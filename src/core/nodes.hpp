#pragma once
// Nodes: from sums to velocities.
//
//   v_i = q_i / m_i,   v_i' = v_i + dt (f_i / m_i + g) , then damping, then walls
//   left for the gather: v_i' and dv_i = v_i' - v_i
//
// A node is +0 plus its tiles in the order of the offset delta, never of keys or ranks, so that an
// absent tile and a zero tile are the same and all copies of a node are updated identically. Local
// non-viscous damping follows Cundall (1987): a fraction of |f| against the velocity.
//
// Nodes with less than `mass_cutoff` take no part: their velocity would be a ratio of roundings.
// Impulses of walls and damping are summed exactly, each node by the owner of the first occupied
// block c - delta, in offset order, whose tile covers it.

#include "core/exact_sum.hpp"
#include "core/grid_views.hpp"
#include "core/quad.hpp"
#include "core/walls.hpp"

namespace moraine {

/// What a round asks of the nodes.
enum class NodeTask {
    solve,     ///< v' and dv from all sums
    velocity,  ///< v of the momentum; the former v' moves to the second quad (MUSL, USF)
};

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

/// Takes the damping of one round from v.
template <class Real, int Dim>
MORAINE_HD void damp_node(const NodeRound<Real, Dim>& round, const Quad<Real>& force, Real inverse, Vec<Real, Dim>& v) {
    using std::fabs;
    for (int a = 0; a < Dim; ++a) {
        const Real brake = round.damping * round.dt * fabs(force[a] * inverse + round.gravity[a]);
        v[a] -= v[a] > Real(0) ? brake : (v[a] < Real(0) ? -brake : Real(0));
    }
}

/// The formula: from a node's sums (m, q) and (f, 0) to its velocities. `node`: its index; null where no wall is near.
template <class Real, int Dim>
MORAINE_HD NodeMotion<Real, Dim> move_node(const NodeRound<Real, Dim>& round, const Walls<Real, Dim>& walls,
                                           const Quad<Real>& sums, const Quad<Real>& force, const int* node) {
    NodeMotion<Real, Dim> motion;
    motion.start = motion.trial = motion.end = zero_vec<Real, Dim>();
    const Real m = sums[0];
    if (!(m > round.mass_cutoff)) return motion;
    const Real inverse = Real(1) / m;
    for (int a = 0; a < Dim; ++a) motion.start[a] = sums[1 + a] * inverse;
    Vec<Real, Dim> v = motion.start;
    if (round.task == NodeTask::solve)
        for (int a = 0; a < Dim; ++a) v[a] += round.dt * (force[a] * inverse + round.gravity[a]);
    motion.trial = v;
    if (round.damping > Real(0) && round.task == NodeTask::solve) damp_node(round, force, inverse, v);
    if (node) walls.constrain(node, v);
    motion.end = v;
    return motion;
}

template <class Real, int Dim>
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

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int c = chosen[item];
        for (int a = 0; a < Dim; ++a) impulse[item * Dim + a] = ExactSum{};
        if (grid.node_of[c] < 0) return;
        const bool border = table.node_border[c] != 0;
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
        team.each(Block<Dim>::cells, [&](int n) { finish(c, item, n, border, scratch); });
    }

  private:
    MORAINE_HD void add_tile_node(int n, int delta, int source, int tile, Scratch& scratch) const {
        const int side = tile_side(width);
        int at = 0;
        for (int a = Dim - 1; a >= 0; --a) {
            const int x = cell_coordinate_of(n, a);
            const int upper = Block<Dim>::corner(delta, a);
            if (upper && x >= width - 1) return;
            at = at * side + x + 4 * upper;
        }
        const Real* from = grid.tiles + (std::size_t(tile) * power<Dim>(side) + at) * node_reals;
        scratch.sums[2 * n] = scratch.sums[2 * n] + Quad<Real>::load(from);
        scratch.sums[2 * n + 1] = scratch.sums[2 * n + 1] + Quad<Real>::load(from + quad);
        if (scratch.counted_by[n] < 0) scratch.counted_by[n] = source;
    }

    static MORAINE_HD int cell_coordinate_of(int n, int axis) { return (n >> (2 * axis)) & 3; }

    MORAINE_HD void finish(int c, int item, int n, bool border, Scratch& scratch) const {
        Real* out = grid.nodes + (std::size_t(grid.node_of[c]) * Block<Dim>::cells + n) * node_reals;
        const Quad<Real>& sums = scratch.sums[2 * n];
        int node[Dim];
        for (int a = 0; a < Dim; ++a) node[a] = 4 * table.node_position[c][a] - origin + cell_coordinate_of(n, a);
        const NodeMotion<Real, Dim> motion =
            move_node(round, walls, sums, scratch.sums[2 * n + 1], border ? node : nullptr);
        const bool solved = round.task == NodeTask::solve;
        if ((border || round.damping > Real(0)) && solved && scratch.counted_by[n] < table.own)
            for (int a = 0; a < Dim; ++a) impulse[item * Dim + a].add(quantum.of(motion.impulse(sums[0], a)));
        for (int a = 0; a < Dim; ++a) {
            out[quad + a] = solved ? motion.end[a] - motion.start[a] : out[a];
            out[a] = motion.end[a];
        }
        for (int a = Dim; a < quad; ++a) out[a] = out[quad + a] = Real(0);
    }
};

}  // namespace moraine
