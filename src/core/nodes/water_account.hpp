#pragma once
// What water in the ground does to the momentum and the energy of a run, step by step (core/nodes/water_nodes.hpp).
//
//   mixture:  sum m v + sum b w,   sum m v^2 / 2 + b v . w + a w^2 / 2        a, b: as there
//
// Particles keep the mass that they began with, so the weight of water that came or went, and that of water which
// flows through soil at rest, work beside the potential energy.

#include "core/data/exact_sum.hpp"

namespace moraine {

/// Sums over nodes, particles and steps.
template <int Dim>
struct WaterAccount {
    ExactSum drag;                 ///< what Darcy's drag took [J]
    ExactSum weight;               ///< work of the weight of water besides that of the particles' masses [J]
    ExactSum weight_impulse[Dim];  ///< of that weight [kg m/s]
    ExactSum flux[Dim];            ///< what sum b w has gained [kg m/s]

    MORAINE_HD void add(const WaterAccount& o) {
        drag.add(o.drag), weight.add(o.weight);
        for (int a = 0; a < Dim; ++a) weight_impulse[a].add(o.weight_impulse[a]), flux[a].add(o.flux[a]);
    }
};

}  // namespace moraine
