#pragma once
// Where energy goes at the nodes: what walls, contact and damping take of it, in the energy budget that a scene may ask
// for (output.energy_budget).
//
//   v --blow--> v_b --forces, gravity, and what holds against them--> v'      one round that has forces
//   contact, walls = m (v^2 - v_b^2) / 2 - I . (v_b + v') / 2      I: impulse in the hold
//   damping = -I . (v_b + v') / 2
//   gain = m (v'^2 - v^2) / 2      from sums of particles to what they gather
//   fall = dt m g . v'             what particles that move by v' fall by: sum_p m_p w_ip = m_i, so it is exact
//
// A blow is what walls and structures do to the velocity that particles bring; it takes energy however short a step is.
// Against forces they only hold: a node that is pressed to a wall gets dt f / m and is stopped in each step, which
// takes nothing, as its mean velocity says. The two together are the whole impulse. Walls say what they do to v alone;
// of the impulse of structures the hold is what is against the forces, along it.
//
// The rest of the budget needs no sum over particles in the step. Transfers take what particles had in motion at the
// start, less what they have now, plus the gains: what they lose on the way to the nodes and on the way back. Places
// that change otherwise than by v' (shifts) make the difference between the potential energy and the falls. With the
// grid's pressure (grid_pressure.hpp) a step has a gain per substep and one fall, by the velocity of its end.

#include <cstddef>
#include <cstdint>

#include "core/data/exact_sum.hpp"
#include "core/data/vec.hpp"

namespace moraine {

/// Sums over nodes and steps [J]. Fall: potential energy set free.
struct NodeEnergy {
    ExactSum gain, fall, contact, damping, walls;
    ExactSum slaves;  ///< of contact on surfaces (SurfaceMotion): what slaves' impulses take

    MORAINE_HD void add(const NodeEnergy& o) {
        gain.add(o.gain), fall.add(o.fall), contact.add(o.contact), damping.add(o.damping), walls.add(o.walls);
        slaves.add(o.slaves);
    }
};

/// m (from - to) . (start + end) / 2: what an impulse takes that changes `from` into `to` [J].
template <class Real, int Dim>
MORAINE_HD double energy_taken(Real mass, const Vec<Real, Dim>& from, const Vec<Real, Dim>& to,
                               const Vec<Real, Dim>& start, const Vec<Real, Dim>& end) {
    double sum = 0;
    for (int i = 0; i < Dim; ++i) sum += (double(from[i]) - double(to[i])) * (double(start[i]) + double(end[i]));
    return 0.5 * double(mass) * sum;
}

/// Of the impulse of structures, m (after - trial), the share that holds against the forces'.
template <class Real, int Dim>
MORAINE_HD Real share_that_holds(const Vec<Real, Dim>& start, const Vec<Real, Dim>& trial,
                                 const Vec<Real, Dim>& after) {
    Real square = Real(0), against = Real(0);
    for (int a = 0; a < Dim; ++a) {
        const Real given = after[a] - trial[a];
        square += given * given;
        against -= given * (trial[a] - start[a]);
    }
    const Real share = square > Real(0) ? against / square : Real(0);
    return share < Real(0) ? Real(0) : share > Real(1) ? Real(1) : share;
}

/// Velocity after the blow of structures: of their impulse m (after - trial), without what holds.
template <class Real, int Dim>
MORAINE_HD Vec<Real, Dim> stopped_by(const Vec<Real, Dim>& start, const Vec<Real, Dim>& trial,
                                     const Vec<Real, Dim>& after) {
    const Real share = share_that_holds(start, trial, after);
    Vec<Real, Dim> v = start;
    for (int a = 0; a < Dim; ++a) v[a] += (Real(1) - share) * (after[a] - trial[a]);
    return v;
}

/// What a round and the surfaces behind it do to a node beside surfaces that act where they are (numerics.bed). Changes
/// of its velocity are what is taken [m/s].
template <class Real, int Dim>
struct SurfaceMotion {
    Real mass;                         ///< [kg]; 0: this rank does not count the node
    Vec<Real, Dim> start, trial, end;  ///< before, by forces alone, and now
    Vec<Real, Dim> damping, walls;     ///< taken
    Vec<Real, Dim> elements, slaves;   ///< likewise, by what acts on surfaces
};

/// Where a round leaves those, by node block; motion: null where it counts all nodes itself.
template <class Real, int Dim>
struct SurfaceMotions {
    SurfaceMotion<Real, Dim>* motion = nullptr;  ///< [near node block][node]
    const std::int32_t* near_of = nullptr;       ///< by node block; -1: no surface is near

    MORAINE_HD SurfaceMotion<Real, Dim>* of(int c, int n, int nodes) const {
        return motion && near_of[c] >= 0 ? motion + std::size_t(near_of[c]) * std::size_t(nodes) + std::size_t(n)
                                         : nullptr;
    }
};

/// m g . v [W].
template <class Real, int Dim>
MORAINE_HD double power_of_weight(Real mass, const Vec<Real, Dim>& gravity, const Vec<Real, Dim>& velocity) {
    double sum = 0;
    for (int i = 0; i < Dim; ++i) sum += double(gravity[i]) * double(velocity[i]);
    return double(mass) * sum;
}

/// Accounts of the energy that grow step by step, on each rank for what it did (core/transfer/totals.hpp) [J].
struct EnergyAccount {
    NodeEnergy nodes;
    ExactSum pressures;                     ///< taken by those of cells beside surfaces: from nodes, less to particles
    ExactSum put_out;                       ///< potential energy set free where soil is put out of structures
    ExactSum lost_kinetic, lost_potential;  ///< of what left through open ends

    void add(const EnergyAccount& o) {
        nodes.add(o.nodes);
        pressures.add(o.pressures);
        put_out.add(o.put_out), lost_kinetic.add(o.lost_kinetic), lost_potential.add(o.lost_potential);
    }
};

}  // namespace moraine
