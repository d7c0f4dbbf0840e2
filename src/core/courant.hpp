#pragma once
// Time steps by method: how far a wave and its particle may go in one, dt (c + |v|) / h.
//
// The limits are measured: a cloud of linear elastic particles that drifts over the grid, in 1-D, 2-D and 3-D, full and
// with free surfaces, is stable below them and not above (S1, docs/stability.md). What stands still allows up to 2.7
// times as much, which is of no use. A scene that does not say its `cfl` takes 0.8 of its method's limit.

#include <algorithm>
#include <cmath>

#include "core/scene_spec.hpp"

namespace moraine {

/// Largest stable step of a method, adrift; of FMPM before the factor of courant_number(). 0: there is no such method.
constexpr double stable_courant(Shape shape, Transfer transfer, StressUpdate update) {
    struct Limits {
        double flip[3], pic[3], apic[3], tpic[3];  // USL, USF, MUSL
        double fmpm;
    };
    constexpr Limits linear{{0.14, 0.31, 0.32}, {0.16, 1.27, 1.27}, {}, {}, 0.13};
    constexpr Limits gimp{{0.61, 0.47, 0.58}, {0.62, 1.46, 1.29}, {0.66, 0.90, 0.68}, {0.67, 0.92, 0.71}, 0.64};
    constexpr Limits quadratic{{0.76, 0.73, 0.78}, {0.76, 1.69, 1.69}, {0.86, 1.0, 1.0}, {0.91, 1.0, 1.0}, 0.78};
    constexpr Limits cubic{{0.95, 1.16, 1.16}, {0.99, 1.89, 1.89}, {1.18, 1.37, 1.37}, {1.20, 1.37, 1.37}, 1.07};
    const Limits& limits = shape == Shape::linear      ? linear
                           : shape == Shape::quadratic ? quadratic
                           : shape == Shape::cubic     ? cubic
                                                       : gimp;  // of either kind
    const auto k = static_cast<std::size_t>(update);
    switch (transfer) {
        case Transfer::flip:
            return limits.flip[k];
        case Transfer::pic:
            return limits.pic[k];
        case Transfer::apic:
            return limits.apic[k];
        case Transfer::tpic:
            return limits.tpic[k];
        case Transfer::aflip:
            return limits.flip[k];
        case Transfer::fmpm:
            return update == StressUpdate::usl ? limits.fmpm : 0;
    }
    return 0;
}

/// A scene may say this much with any method: what stands still is stable there, and scenes have long said so.
inline constexpr double accepted_courant = 0.5;

/// The step of a scene that does not say its own: 0.8 of the limit.
constexpr double standard_courant(const Scene& scene) {
    return 0.8 * stable_courant(scene.shape, scene.transfer, scene.stress_update);
}

/// cfl for the scene's method: k terms of FMPM make the stiffest motion of the nodes up to k times as stiff as it is
/// with the lumped mass, so their step is 1 / sqrt(k) of its step (measured: docs/stability.md).
inline double courant_number(const Scene& scene) {
    return scene.transfer == Transfer::fmpm ? scene.cfl / std::sqrt(double(scene.order)) : scene.cfl;
}

/// Largest share of a cell that the flow's own signal, shear wave and motion, crosses in a step with substeps.
inline constexpr double flow_courant = 0.5;

/// A step and its substeps (grid_pressure.hpp).
struct StepChoice {
    double dt;  ///< [s]
    int substeps;
};

/// signal: c + |v|; speed: |v|, the largest of all particles [m/s]. shear: c_s / c, the largest of all materials.
inline StepChoice choose_step(const Scene& scene, double signal, double speed, double shear) {
    const double wave = courant_number(scene) * scene.cell / signal;
    if (scene.substeps == 1) return {wave, 1};
    const double flow = flow_courant * scene.cell / (shear * (signal - speed) + speed);
    const double most = std::min(std::max(flow, wave), scene.substeps * wave);
    return {most, static_cast<int>(std::ceil(most / wave * (1 - 1e-12)))};
}

}  // namespace moraine
