#pragma once
// The energy budget of nodes beside surfaces that act where they are (core/surfaces/surface_elements.hpp).
//
// Elements act behind a round, so that its energy is counted when they have acted: of their impulses, as of those of
// structures at nodes (node_energy.hpp), what is a blow takes the motion that it stops, and what holds against forces
// its impulse times the mean velocity.

#include "core/nodes/nodes.hpp"

namespace moraine {

/// a + s b.
template <class Real, int Dim>
Vec<Real, Dim> sum_of(const Vec<Real, Dim>& a, Real s, const Vec<Real, Dim>& b) {
    Vec<Real, Dim> sum;
    for (int i = 0; i < Dim; ++i) sum[i] = a[i] + s * b[i];
    return sum;
}

/// Adds what a round and surfaces did to a node. node: its index; null where no wall is near.
template <class Real, int Dim>
void add_surface_energy(const NodeRound<Real, Dim>& round, const Walls<Real, Dim>& walls, const int* node,
                        const SurfaceMotion<Real, Dim>& m, const Quantum& quantum, NodeEnergy& energy) {
    if (!(m.mass > Real(0))) return;
    using V = Vec<Real, Dim>;
    const V surface = sum_of(m.elements, Real(1), m.slaves), none = zero_vec<Real, Dim>();
    const Real holds = share_that_holds(m.start, m.trial, sum_of(m.trial, Real(-1), surface));
    const V blow = sum_of(m.start, holds - Real(1), surface);
    V stopped = blow;
    if (node) walls.constrain(node, stopped);
    const auto taken = [&](Real share, const V& by, const V& before, const V& after) {
        return double(share) * energy_taken(m.mass, by, none, before, after);
    };
    const auto by_surface = [&](const V& by) {
        return taken(Real(1) - holds, by, m.start, blow) + taken(holds, by, stopped, m.end);
    };
    const bool goes_on = round.task == NodeTask::substep && !round.first_substep;
    const V moves = goes_on ? sum_of(m.end, Real(-1), m.start) : m.end;
    const double dt = double(round.task == NodeTask::substep ? round.step : round.dt);
    const V wall = sum_of(blow, Real(-1), stopped), holds_up = sum_of(m.walls, Real(-1), wall);
    energy.gain.add(quantum.of(energy_taken(m.mass, m.end, m.start, m.start, m.end)));
    energy.fall.add(quantum.of(dt * power_of_weight(m.mass, round.gravity, moves)));
    energy.contact.add(quantum.of(by_surface(m.elements)));
    energy.slaves.add(quantum.of(by_surface(m.slaves)));
    energy.damping.add(quantum.of(taken(Real(1), m.damping, stopped, m.end)));
    energy.walls.add(quantum.of(taken(Real(1), wall, blow, stopped) + taken(Real(1), holds_up, stopped, m.end)));
}

}  // namespace moraine
