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

#include "core/data/exact_sum.hpp"
#include "core/data/grid_views.hpp"
#include "core/grid/tile_sums.hpp"
#include "core/grid/walls.hpp"
#include "core/nodes/node_energy.hpp"
#include "core/nodes/water_nodes.hpp"
#include "core/structures/contact.hpp"

namespace moraine {

/// What a round asks of the nodes.
enum class NodeTask {
    solve,     ///< v' and dv from all sums
    velocity,  ///< v of the momentum, before the forces (USF); the former v' moves to the second quad
    again,     ///< the same after the forces (MUSL): what they press against a wall with friction stays there
    begin,     ///< v_1 = v' of a series, and the sum so far
    extend,    ///< v_l+1 from v_l and the momentum of S v_l, and the sum so far
    conclude,  ///< the sum, with its last term
    hold,      ///< v of the momentum, and what stays through the substeps of the grid's pressure (grid_pressure.hpp)
    substep,   ///< v' by what was held and the cells' forces; dv goes on
};

/// Whether forces act.
MORAINE_HD constexpr bool solves(NodeTask task) {
    return task == NodeTask::solve || task == NodeTask::begin || task == NodeTask::substep;
}
/// Whether the particles keep what walls and structures give the nodes.
MORAINE_HD constexpr bool counts(NodeTask task) {
    return task != NodeTask::velocity && task != NodeTask::again && task != NodeTask::hold;
}
/// Whether the node's values of the round before are needed.
MORAINE_HD constexpr bool remembers(NodeTask task) {
    return !solves(task) || task == NodeTask::substep;
}

/// What all nodes of a round share.
template <class Real, int Dim>
struct NodeRound {
    NodeTask task;
    Real dt;                     ///< in which forces act [s]
    Vec<Real, Dim> gravity;      ///< [m/s2]
    Real damping;                ///< [-]
    Real mass_cutoff;            ///< [kg]
    bool first_substep = false;  ///< of tasks that are one
    Real step = Real(0);         ///< of a substep: the step's dt [s]

    MORAINE_HD ContactTime contact_time() const { return {double(dt), double(task == NodeTask::substep ? step : dt)}; }
};

/// What stays at a node through the substeps of a step.
template <class Real, int Dim>
struct HeldNode {
    Vec<Real, Dim> acceleration;  ///< f_i / m_i of deviators and body forces [m/s2]
    Real filling;                 ///< v_i / h^d [-]
};

template <class Real, int Dim>
struct HeldNodes {
    HeldNode<Real, Dim>* node = nullptr;  ///< [node block][node]
    Real inverse_volume = Real(0);        ///< 1 / h^d [1/m3]
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
        if (task == NodeTask::substep) now.second[a] = former.second[a] + (motion.end[a] - motion.start[a]);
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

/// Of a node without water.
struct NothingBorne {
    template <class Velocity>
    MORAINE_HD Velocity operator()(const Velocity&, const Velocity&) const {
        return {};
    }
};

/// The formula: from a node's sums (m, q) and (f, 0) to its velocities. former: its values of the round before, where
/// the task remembers them. `node`: its index; null where no wall is near. touch(v) applies the structures and says
/// whether one touches; borne(start, trial) is what water bears of a wall (Walls::constrain).
template <class Real, int Dim, class Touch = Untouched, class Borne = NothingBorne>
MORAINE_HD NodeMotion<Real, Dim> move_node(const NodeRound<Real, Dim>& round, const Walls<Real, Dim>& walls,
                                           const Quad<Real>& sums, const Quad<Real>& force,
                                           const NodeValues<Real, Dim>& former, const int* node,
                                           const Touch& touch = {}, const Borne& borne = {}) {
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
    if (node) walls.constrain(node, v, borne(motion.start, motion.trial));
    motion.end = v;
    return motion;
}

/// What a round that has forces does to the energy of a node. after_contact, touched: what structures left of
/// motion.trial, and whether one touches; node: as in move_node.
template <class Real, int Dim>
MORAINE_HD void add_energy(const NodeRound<Real, Dim>& round, const Walls<Real, Dim>& walls, const int* node,
                           const Quad<Real>& sums, const Quad<Real>& force, const NodeMotion<Real, Dim>& motion,
                           const Vec<Real, Dim>& after_contact, bool touched, const Quantum& quantum,
                           NodeEnergy& energy) {
    const Real m = sums[0];
    if (!(m > round.mass_cutoff)) return;
    Vec<Real, Dim> damped = after_contact, moves = motion.end;
    if (round.damping > Real(0) && !touched) damp_node(round, force, Real(1) / m, damped);
    // particles move once in a step, by the velocity of its end: the last of these differences is added to the first
    const bool goes_on = round.task == NodeTask::substep && !round.first_substep;
    for (int a = 0; goes_on && a < Dim; ++a) moves[a] -= motion.start[a];
    const double dt = double(round.task == NodeTask::substep ? round.step : round.dt);
    const Vec<Real, Dim> blow = stopped_by(motion.start, motion.trial, after_contact);
    Vec<Real, Dim> held = blow;  // with it, and walls alone
    if (node) walls.constrain(node, held);
    const auto taken = [&](const auto& from, const auto& to, const auto& before, const auto& after) {
        return energy_taken(m, from, to, before, after);
    };
    const auto& end = motion.end;
    // of the impulse that structures and walls give, what is left of the blow
    Vec<Real, Dim> contact, wall;
    for (int a = 0; a < Dim; ++a) {
        contact[a] = (motion.trial[a] - after_contact[a]) - (motion.start[a] - blow[a]);
        wall[a] = (damped[a] - end[a]) - (blow[a] - held[a]);
    }
    const Vec<Real, Dim> none = zero_vec<Real, Dim>();
    energy.gain.add(quantum.of(taken(end, motion.start, motion.start, end)));
    energy.fall.add(quantum.of(dt * power_of_weight(m, round.gravity, moves)));
    energy.contact.add(quantum.of(taken(motion.start, blow, motion.start, blow) + taken(contact, none, held, end)));
    energy.damping.add(quantum.of(taken(after_contact, damped, held, end)));
    energy.walls.add(quantum.of(taken(blow, held, blow, held) + taken(wall, none, held, end)));
}

/// What a round that has forces did to a node, before surfaces act on it.
template <class Real, int Dim>
MORAINE_HD SurfaceMotion<Real, Dim> motion_before_surfaces(const NodeRound<Real, Dim>& round, const Quad<Real>& sums,
                                                           const Quad<Real>& force, const NodeMotion<Real, Dim>& motion,
                                                           bool counted) {
    SurfaceMotion<Real, Dim> m{};
    m.start = motion.start, m.trial = motion.trial, m.end = motion.end;
    if (!(sums[0] > round.mass_cutoff)) return m;
    if (counted) m.mass = sums[0];
    Vec<Real, Dim> damped = motion.trial;
    if (round.damping > Real(0)) damp_node(round, force, Real(1) / sums[0], damped);
    for (int a = 0; a < Dim; ++a) {
        m.damping[a] = motion.trial[a] - damped[a];
        m.walls[a] = damped[a] - motion.end[a];
    }
    return m;
}

/// One instance for scenes with structures, one for the others; each with the energy budget and without.
template <class Real, int Dim, bool Contact = false, bool Energy = false>
struct SolveNodes {
    using Scratch = TileSums<Real, Dim>;

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
    HeldNodes<Real, Dim> held = {};
    NodeEnergy* energy = nullptr;             ///< node blocks, with an energy budget: of this step
    SurfaceMotions<Real, Dim> surfaces = {};  ///< of nodes whose energy is counted behind surfaces
    WaterNodes<Real, Dim> water = {};         ///< in the pores

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch& scratch) const {
        const int c = chosen[item];
        if (round.task != NodeTask::substep || round.first_substep) {
            for (int a = 0; a < Dim; ++a) impulse[item * Dim + a] = ExactSum{};
            if constexpr (Energy) energy[item] = NodeEnergy{};
            if (water.account) water.account[item] = {};
        }
        if (grid.node_of[c] < 0) return;
        const bool border = table.node_border[c] != 0;
        const bool near = structure_near(c);
        scratch.find(team, table, grid, width, c);
        if (round.task == NodeTask::hold)
            team.each(Block<Dim>::cells, [&](int n) { hold(c, n, scratch); });
        else
            team.each(Block<Dim>::cells, [&](int n) { finish(c, item, n, border, near, scratch); });
    }

  private:
    /// What structures leave of a node's velocity.
    struct Contacted {
        Vec<Real, Dim> velocity;
        bool touched;
    };

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

    template <class Values, class FollowingOf>
    void tell(int k, const Values& values, const FollowingOf& following) const {
        add_shared(contact.sums[k].sum, quantum, values);
        if (contact.structure[k].turns) add_following(following(), quantum, contact.turning[k]);
    }

    MORAINE_HD std::size_t stored(int c, int n) const { return std::size_t(grid.node_of[c]) * Block<Dim>::cells + n; }

    /// Substeps begin.
    MORAINE_HD void hold(int c, int n, Scratch& scratch) const {
        Real* out = grid.nodes + stored(c, n) * node_reals;
        HeldNode<Real, Dim>& kept = held.node[stored(c, n)];
        const Quad<Real>&sums = scratch.sums[2 * n], &force = scratch.sums[2 * n + 1];
        const bool heavy = sums[0] > round.mass_cutoff;
        const Real inverse = heavy ? Real(1) / sums[0] : Real(0);
        for (int q = 0; q < node_reals; ++q) out[q] = Real(0);
        for (int a = 0; a < Dim; ++a) {
            out[a] = sums[1 + a] * inverse;
            kept.acceleration[a] = force[a] * inverse;
        }
        out[quad - 1] = sums[0];
        kept.filling = force[quad - 1] * held.inverse_volume;
    }

    /// The sums of a substep, as those of a step: (m, q) and f.
    MORAINE_HD void take_held(int c, int n, const int* node, Scratch& scratch, const Real* out) const {
        const HeldNode<Real, Dim>& kept = held.node[stored(c, n)];
        Quad<Real>&sums = scratch.sums[2 * n], &force = scratch.sums[2 * n + 1];
        const Real mean = out[2 * quad - 1], m = out[quad - 1];
        if (water.node) water.begin(stored(c, n), sums);
        Vec<Real, Dim> momentum, total;
        for (int a = 0; a < Dim; ++a) momentum[a] = m * out[a], total[a] = force[a] + m * kept.acceleration[a];
        sums = Quad<Real>::scaled_after(m, Real(1), momentum);
        if (water.node) water.press_on_soil(stored(c, n), node, m, round.gravity, round.dt, total);
        force = Quad<Real>::scaled(Real(1), total) + Quad<Real>::of(Real(0), Real(0), Real(0), mean * m);
    }

    /// Of a node that no structure touches.
    MORAINE_HD NodeMotion<Real, Dim> move_untouched(std::size_t at, const int* node, bool border,
                                                    const Scratch& scratch, int n,
                                                    const NodeValues<Real, Dim>& former) const {
        const Quad<Real>& sums = scratch.sums[2 * n];
        return move_node(round, walls, sums, scratch.sums[2 * n + 1], former, border ? node : nullptr, Untouched{},
                         [&](const Vec<Real, Dim>& start, const Vec<Real, Dim>& trial) {
                             if (!water.node || round.task != NodeTask::substep) return zero_vec<Real, Dim>();
                             return water.borne(at, node, sums[0], start, trial, round.dt);
                         });
    }

    MORAINE_HD void count_energy(int c, int item, int n, const int* node, bool counted,
                                 const NodeMotion<Real, Dim>& motion, const Contacted& left, Scratch& scratch) const {
        const Quad<Real>&sums = scratch.sums[2 * n], &force = scratch.sums[2 * n + 1];
        SurfaceMotion<Real, Dim>* beside = surfaces.of(c, n, Block<Dim>::cells);
        if (beside)
            *beside = motion_before_surfaces(round, sums, force, motion, counted);
        else if (counted)
            add_energy(round, walls, node, sums, force, motion, left.velocity, left.touched, quantum, energy[item]);
    }

    /// Moves the water in the pores; what walls give it.
    MORAINE_HD Vec<double, Dim> flow(std::size_t at, int item, const int* node, bool counted, Real m,
                                     const NodeMotion<Real, Dim>& motion) const {
        const FlowMotion<Real, Dim> f = water.flow(at, node, m, round, motion);
        Vec<double, Dim> given;
        for (int a = 0; a < Dim; ++a) given[a] = water.impulse(at, f, a);
        if (counted)
            water.count(at, node, round.dt, motion, f, quantum, water.account[item], Energy ? energy + item : nullptr);
        return given;
    }

    MORAINE_HD void finish(int c, int item, int n, bool border, bool near, Scratch& scratch) const {
        Real* out = grid.nodes + stored(c, n) * node_reals;
        int node[Dim];
        for (int a = 0; a < Dim; ++a) node[a] = 4 * table.node_position[c][a] - origin + cell_coordinate_of(n, a);
        if (round.task == NodeTask::substep) take_held(c, n, node, scratch, out);
        const Quad<Real>& sums = scratch.sums[2 * n];
        const bool counted = counts(round.task) && scratch.counted_by[n] < table.own;
        NodeValues<Real, Dim> former{};
        for (int a = 0; a < Dim; ++a) {
            if (remembers(round.task)) former.first[a] = out[a], former.second[a] = out[quad + a];
        }
        NodeMotion<Real, Dim> motion;
        Vec<double, Dim> given = zero_vec<double, Dim>();  // to structures, and by walls to pore water
        Contacted contacted{zero_vec<Real, Dim>(), false};
        if constexpr (Contact) {
            motion =
                move_node(round, walls, sums, scratch.sums[2 * n + 1], former, border ? node : nullptr, [&](auto& v) {
                    const bool touched =
                        near && touch_structures(
                                    contact, node, sums[0], round.contact_time(),
                                    [&](int k) { return gap_at_node(gaps, table, grid.tile_of, width, c, n, k); },
                                    [&](int k, const auto& values, const auto& following) {
                                        if (counted) tell(k, values, following);
                                    },
                                    v, given,
                                    contact.ground ? contact.ground + std::size_t(c) * Block<Dim>::cells + n : nullptr);
                    if constexpr (Energy) contacted = {v, touched};
                    return touched;
                });
        } else {
            motion = move_untouched(stored(c, n), node, border, scratch, n, former);
        }
        const bool flows = water.node && round.task == NodeTask::substep;
        if (flows) given = flow(stored(c, n), item, node, counted, sums[0], motion);
        if ((border || round.damping > Real(0)) && counted)
            for (int a = 0; a < Dim; ++a)
                impulse[item * Dim + a].add(quantum.of(motion.impulse(sums[0], a) + given[a]));
        if constexpr (Energy) {
            const Vec<Real, Dim> after = Contact ? contacted.velocity : motion.trial;
            if (solves(round.task))
                count_energy(c, item, n, border ? node : nullptr, counted, motion, {after, contacted.touched}, scratch);
        }
        const NodeValues<Real, Dim> now = values_after(round.task, motion, former);
        for (int a = 0; a < Dim; ++a) out[a] = now.first[a], out[quad + a] = now.second[a];
        for (int a = Dim; a < quad; ++a) out[a] = out[quad + a] = Real(0);
        out[quad - 1] = sums[0];
        if (sums[0] > round.mass_cutoff) out[2 * quad - 1] = scratch.sums[2 * n + 1][quad - 1] / sums[0];
    }
};

}  // namespace moraine
