#pragma once
// Nodes of saturated soil: its velocity v and Darcy's flux w, which share the force of the pore pressure.
//
//   m dv + b dw = dts (f + m g)                    f: of effective stress, of loads and of pore pressure F
//   b dv + a dw = dts (b g + F - R (w + dw))       a, b, R: sums of V rho_w / n, V rho_w, V gamma_w / k, of what is wet
//
// Drag is implicit, so it sets no limit to the step: with A the mass matrix of both, A + dts R / 2 is trapezoidal drag
// with more mass (docs/theory/water.md). What holds v (walls) acts between the two: first dw by both equations gives
// the force on v, then dw again by the second and the dv that came out. Where nothing holds v both are the same; where
// it is held, w does not feel the weight that a wall bears. A closed end holds w across it, an open one does not; along
// it w is free. A wall's friction is by the effective stress: of the impulse m dv that holds v at a closed one, water
// bears b dv - dts (b g + F), and at an open one b^2 / D dv, D = a + dts R.

#include "core/grid/walls.hpp"
#include "core/nodes/node_energy.hpp"
#include "core/nodes/water_account.hpp"

namespace moraine {

/// What a node holds of the flux through a step.
template <class Real, int Dim>
struct WaterNode {
    Real inertia;          ///< a [kg]; 0: no water
    Real water;            ///< b [kg]
    Real resistance;       ///< R [N s/m]
    Vec<Real, Dim> flux;   ///< w [m/s]
    Vec<Real, Dim> start;  ///< w before the step [m/s]
    Vec<Real, Dim> force;  ///< F of the substep [N]
    Real pressure;         ///< P of the cell around it before the step, tension positive, where mobility is not 0 [Pa]
    Real mobility;         ///< of its water, k / gamma_w or less; 0: the cell is not full [m4/(N s)]
    Real spread;           ///< sum of second differences that this cell takes part in [m^(d+2)/(N s) Pa]
};

/// w of a substep [m/s]: before, by forces alone, and with walls.
template <class Real, int Dim>
struct FlowMotion {
    Vec<Real, Dim> start, trial, end;
};

template <class Real, int Dim>
struct WaterNodes {
    WaterNode<Real, Dim>* node = nullptr;  ///< [node block][node]; null: the scene has no water
    WaterAccount<Dim>* account = nullptr;  ///< by node block that is solved
    Vec<Real, Dim> weight = {};  ///< gravity that acts on w; 0 where p is that in excess of still water [m/s2]
    int plane[Dim][2] = {};      ///< as in Walls
    bool closed[Dim][2] = {};    ///< no water passes

    /// Whether an end holds w along an axis there.
    MORAINE_HD bool holds(const int* at, int a) const {
        return (closed[a][0] && at[a] <= plane[a][0]) || (closed[a][1] && at[a] >= plane[a][1]);
    }

    /// Takes F from a substep's sums, and what they say of pressures.
    MORAINE_HD void begin(std::size_t index, const auto& sums) const {
        WaterNode<Real, Dim>& w = node[index];
        w.spread = sums[0];
        for (int a = 0; a < Dim; ++a) w.force[a] = sums[1 + a];
    }

    /// Makes of the force f without F that which moves v as both equations do [N].
    MORAINE_HD void press_on_soil(std::size_t index, const int* at, Real m, const Vec<Real, Dim>& gravity, Real dt,
                                  Vec<Real, Dim>& force) const {
        const WaterNode<Real, Dim>& w = node[index];
        const Real b = w.water, D = w.inertia + dt * w.resistance;
        for (int a = 0; a < Dim; ++a) {
            force[a] += w.force[a];
            if (!(w.inertia > Real(0)) || holds(at, a)) continue;
            const Real own = b * weight[a] + w.force[a] - w.resistance * w.flux[a];
            force[a] -= b * (m * own - b * (force[a] + m * gravity[a])) / (m * D - b * b);
        }
    }

    /// What a wall's friction does not see of the impulse along each axis that stops v there; over m [m/s]. start,
    /// trial: v before and by forces alone. Along the wall w follows, so that friction moves m - b^2 / D.
    MORAINE_HD Vec<Real, Dim> borne(std::size_t index, const int* at, Real m, const Vec<Real, Dim>& start,
                                    const Vec<Real, Dim>& trial, Real dt) const {
        const WaterNode<Real, Dim>& w = node[index];
        Vec<Real, Dim> borne = zero_vec<Real, Dim>();
        if (!(w.inertia > Real(0))) return borne;
        const Real b = w.water, D = w.inertia + dt * w.resistance, moved = Real(1) - b * b / (m * D);
        for (int a = 0; a < Dim; ++a) {
            const Real of_water = -(b * start[a] + dt * (b * weight[a] + w.force[a])) / m;
            if (holds(at, a)) borne[a] = -trial[a] + (trial[a] + of_water) / moved;
        }
        return borne;
    }

    /// w after the substep, by the motion of the soil. round: as nodes.hpp has it.
    MORAINE_HD FlowMotion<Real, Dim> flow(std::size_t index, const int* at, Real m, const auto& round,
                                          const auto& motion) const {
        WaterNode<Real, Dim>& w = node[index];
        const bool wet = w.inertia > Real(0) && m > round.mass_cutoff;
        const Real dt = round.dt, b = w.water, D = w.inertia + dt * w.resistance;
        FlowMotion<Real, Dim> f;
        f.start = f.trial = f.end = zero_vec<Real, Dim>();
        for (int a = 0; a < Dim && wet; ++a) {
            f.start[a] = f.trial[a] = w.flux[a];
            if (holds(at, a)) continue;
            const Real own = dt * (b * weight[a] + w.force[a] - w.resistance * w.flux[a]);
            f.trial[a] += (own - b * (motion.trial[a] - motion.start[a])) / D;
            f.end[a] = f.start[a] + (own - b * (motion.end[a] - motion.start[a])) / D;
        }
        w.flux = f.end;
        return f;
    }

    /// What a wall gives the water of a node [kg m/s].
    MORAINE_HD double impulse(std::size_t index, const FlowMotion<Real, Dim>& f, int a) const {
        return double(node[index].water) * (double(f.end[a]) - double(f.trial[a]));
    }

    /// What the water of a node did: drag and weight, and with an energy budget what it has of gain and walls' work.
    /// Of the trapezoidal drag of docs/theory/water.md, -dts w' . R (w + w') / 2.
    MORAINE_HD void count(std::size_t index, const int* at, Real dt, const auto& motion, const FlowMotion<Real, Dim>& f,
                          const Quantum& quantum, WaterAccount<Dim>& sums, NodeEnergy* energy) const {
        const WaterNode<Real, Dim>& w = node[index];
        const double a_i = double(w.inertia), b = double(w.water);
        double drag = 0, fall = 0, gain = 0, walls = 0;
        for (int a = 0; a < Dim; ++a) {
            const double w0 = double(f.start[a]), w1 = double(f.end[a]), mean = 0.5 * (w0 + w1);
            const double v0 = double(motion.start[a]), v1 = double(motion.end[a]);
            drag += double(dt) * double(w.resistance) * w1 * mean;
            fall += double(dt) * b * double(weight[a]) * mean;
            gain += b * (v1 * w1 - v0 * w0) + 0.5 * a_i * (w1 * w1 - w0 * w0);
            walls += holds(at, a) ? (b * v0 + 0.5 * a_i * w0) * w0 : -0.5 * impulse(index, f, a) * (v0 + v1);
            sums.flux[a].add(quantum.of(b * (w1 - w0)));
        }
        sums.drag.add(quantum.of(drag));
        sums.weight.add(quantum.of(fall));
        if (!energy) return;
        energy->gain.add(quantum.of(gain));
        energy->walls.add(quantum.of(walls));
    }
};

}  // namespace moraine
