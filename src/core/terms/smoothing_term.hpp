#pragma once
// Pressure smoothing (pressure_smoothing.hpp) as a term. Where the pressure is the grid's it stays inside a cell
// (grid_pressure.hpp).

#include "core/fluid/grid_pressure.hpp"
#include "core/fluid/pressure_smoothing.hpp"
#include "core/terms/gather_point.hpp"
#include "core/terms/terms.hpp"

namespace moraine {

template <class Real>
struct SmoothingTerm {
    static constexpr unsigned hooks = hook_stress;
    const FluidTerms<Real>* fluid;   ///< by body; null: not in this step
    const CellPressure<Real>* cell;  ///< [tile][cell]; null: nodes hold the means

    MORAINE_HD bool on(const auto&) const { return fluid != nullptr; }

    MORAINE_HD void before_stress(const auto& of, const auto& in, const auto& point, auto&, auto&, auto&) const {
        const FluidTerms<Real>& own = fluid[of.p.body[point.slot]];
        if (!(own.smoothing > Real(0))) return;
        const Real head = cell ? of.cell_of(cell, in).head : point.sums.change()[quad - 1];
        const auto n = point.stencil_of();
        smooth_pressure(own, of.round.dt, head - gravity_pressure(of.context.gravity_slope, in.base, n.f), point);
    }
};

}  // namespace moraine
