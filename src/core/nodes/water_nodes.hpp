#pragma once
// Nodes of saturated soil: its velocity v and Darcy's flux w, which share the force of the pore pressure.
//
//   m dv + b dw = dts (f + m g)                    f: of effective stress, of loads and of pore pressure F
//   b dv + a dw = dts (b g + F - R (w + dw))       a, b, R: sums of V rho_w / n, V rho_w, V gamma_w / k
//
// Drag is implicit, so it sets no limit to the step: with A the mass matrix of both, A + dts R / 2 is trapezoidal drag
// with more mass (docs/theory/water.md). What holds v (walls) acts between the two: first dw by both equations gives
// the force on v, then dw again by the second and the dv that came out. Where nothing holds v both are the same; where
// it is held, w does not feel the weight that a wall bears. A closed end holds w across it, an open one does not; along
// it w is free. A wall's friction is by the effective stress: of the impulse m dv that holds v at a closed one, water
// bears b dv - dts (b g + F), and at an open one b^2 / D dv, D = a + dts R.

#include "core/grid/walls.hpp"

namespace moraine {

/// What a node holds of the flux through a step.
template <class Real, int Dim>
struct WaterNode {
    Real inertia;          ///< a [kg]; 0: no water
    Real resistance;       ///< R [N s/m]
    Vec<Real, Dim> flux;   ///< w [m/s]
    Vec<Real, Dim> start;  ///< w before the step [m/s]
    Vec<Real, Dim> force;  ///< F of the substep [N]
    Real pressure;         ///< P of the cell around it before the step, tension positive, where mobility is not 0 [Pa]
    Real mobility;         ///< of its water, k / gamma_w or less; 0: the cell is not full [m4/(N s)]
    Real spread;           ///< sum of second differences that this cell takes part in [m^(d+2)/(N s) Pa]
};

template <class Real, int Dim>
struct WaterNodes {
    WaterNode<Real, Dim>* node = nullptr;  ///< [node block][node]; null: the scene has no water
    Real full_mass = Real(0);              ///< rho_w h^d: b of a node that is full [kg]
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
    MORAINE_HD void press_on_soil(std::size_t index, const int* at, Real m, Real filling, const Vec<Real, Dim>& gravity,
                                  Real dt, Vec<Real, Dim>& force) const {
        const WaterNode<Real, Dim>& w = node[index];
        const Real b = filling * full_mass, D = w.inertia + dt * w.resistance;
        for (int a = 0; a < Dim; ++a) {
            force[a] += w.force[a];
            if (!(w.inertia > Real(0)) || holds(at, a)) continue;
            const Real own = b * weight[a] + w.force[a] - w.resistance * w.flux[a];
            force[a] -= b * (m * own - b * (force[a] + m * gravity[a])) / (m * D - b * b);
        }
    }

    /// What a wall's friction does not see of the impulse along each axis that stops v there; over m [m/s]. start,
    /// trial: v before and by forces alone. Along the wall w follows, so that friction moves m - b^2 / D.
    MORAINE_HD Vec<Real, Dim> borne(std::size_t index, const int* at, Real m, Real filling, const Vec<Real, Dim>& start,
                                    const Vec<Real, Dim>& trial, Real dt) const {
        const WaterNode<Real, Dim>& w = node[index];
        Vec<Real, Dim> borne = zero_vec<Real, Dim>();
        if (!(w.inertia > Real(0))) return borne;
        const Real b = filling * full_mass, D = w.inertia + dt * w.resistance, moved = Real(1) - b * b / (m * D);
        for (int a = 0; a < Dim; ++a) {
            const Real of_water = -(b * start[a] + dt * (b * weight[a] + w.force[a])) / m;
            if (holds(at, a)) borne[a] = -trial[a] + (trial[a] + of_water) / moved;
        }
        return borne;
    }

    /// w after the substep, by the motion of the soil. held, round: as nodes.hpp has them.
    MORAINE_HD void flow(std::size_t index, const int* at, Real m, const auto& held, const auto& round,
                         const auto& motion) const {
        WaterNode<Real, Dim>& w = node[index];
        const bool wet = w.inertia > Real(0) && m > round.mass_cutoff;
        const Real dt = round.dt, b = held.node[index].filling * full_mass, D = w.inertia + dt * w.resistance;
        for (int a = 0; a < Dim; ++a) {
            if (!wet || holds(at, a)) {
                w.flux[a] = Real(0);
                continue;
            }
            const Real own = b * weight[a] + w.force[a] - w.resistance * w.flux[a];
            w.flux[a] += (dt * own - b * (motion.end[a] - motion.start[a])) / D;
        }
    }

    /// The mass that moves a pressure's force as both do without drag: 1/y, y = (a - 2 b + m) / (m a - b^2) [kg].
    MORAINE_HD Real mass_under_pressure(std::size_t index, Real m, Real filling) const {
        const Real a = node[index].inertia, b = filling * full_mass;
        if (!(a > Real(0))) return m;
        return (m * a - b * b) / (a - Real(2) * b + m);
    }
};

}  // namespace moraine
