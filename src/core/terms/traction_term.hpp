#pragma once
// Tractions as a term: F of the soil that they may act on, and what they do in the step (particles/traction.hpp).

#include "core/particles/particle_load.hpp"
#include "core/terms/terms.hpp"

namespace moraine {

struct TractionTerm {
    static constexpr unsigned hooks = hook_stress;

    MORAINE_HD bool on(const auto& of) const { return of.p.deformation != nullptr; }

    /// F - I <- F - I + dL + dL (F - I); work by the velocities that move the nodes.
    template <class Real, int Dim>
    MORAINE_HD void before_stress(const auto& of, const auto&, const auto& point, Mat<Real, Dim>& dL, auto&,
                                  auto& out) const {
        const Vec<Real, Dim>& force = of.p.load_force[point.slot];
        const Mat<Real, Dim>& couple = of.p.load_couple[point.slot];
        const double dt = double(of.round.dt);
        for (int a = 0; a < Dim; ++a) {
            out.load_impulse[a] += dt * double(force[a]);
            out.load_work += dt * double(force[a]) * double(point.sums.velocity()[a]);
            for (int b = 0; b < Dim; ++b) out.load_work += double(couple(a, b)) * double(dL(a, b));
        }
        deform(dL, of.p.deformation[point.slot]);
    }
};

}  // namespace moraine
