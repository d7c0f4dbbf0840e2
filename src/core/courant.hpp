#pragma once
// Time steps by method: how far a wave and its particle may go in one, dt (c + |v|) / h.
//
// The limits are measured: a cloud of linear elastic particles that drifts over the grid, in 1-D, 2-D and 3-D, full and
// with free surfaces, is stable below them and not above (S1, docs/stability.md). What stands still allows up to 2.7
// times as much, which is of no use. A scene that does not say its `cfl` takes 0.8 of its method's limit.

#include <cmath>

#include "core/scene.hpp"

namespace moraine {

/// Largest stable step of a method, adrift; of FMPM before the factor of courant_number(). 0: not measured.
constexpr double stable_courant(Shape shape, Transfer transfer, StressUpdate update) {
    const bool usl = update == StressUpdate::usl;
    if (shape == Shape::gimp) return usl && transfer == Transfer::flip ? 0.61 : 0;
    if (shape == Shape::quadratic) switch (transfer) {
            case Transfer::flip:
                return usl ? 0.76 : update == StressUpdate::usf ? 0.73 : 0.78;
            case Transfer::apic:
                return usl ? 0.86 : 1.0;
            case Transfer::tpic:
                return usl ? 0.91 : 1.0;
            case Transfer::fmpm:
                return usl ? 0.78 : 0;
            case Transfer::pic:
                return 0;
        }
    if (shape == Shape::cubic) switch (transfer) {
            case Transfer::flip:
                return usl ? 0.95 : 1.16;
            case Transfer::pic:
                return usl ? 0.99 : 1.89;
            case Transfer::apic:
                return usl ? 1.18 : 1.37;
            case Transfer::tpic:
            case Transfer::fmpm:
                return 0;
        }
    return 0;
}

/// The step of a scene that does not say its own: 0.8 of the limit, or 0.5 where that is not known.
constexpr double standard_courant(const Scene& scene) {
    const double limit = stable_courant(scene.shape, scene.transfer, scene.stress_update);
    return limit > 0 ? 0.8 * limit : 0.5;
}

/// cfl for the scene's method: k terms of FMPM make the stiffest motion of the nodes up to k times as stiff as it is
/// with the lumped mass, so their step is 1 / sqrt(k) of its step (measured: docs/stability.md).
inline double courant_number(const Scene& scene) {
    return scene.transfer == Transfer::fmpm ? scene.cfl / std::sqrt(double(scene.order)) : scene.cfl;
}

}  // namespace moraine
