#pragma once
// The pressure of the grid (grid_pressure.hpp) as a term: the volumetric part of a particle's step is that of its cell.

#include "core/fluid/grid_pressure.hpp"
#include "core/terms/gather_point.hpp"
#include "core/terms/terms.hpp"

namespace moraine {

template <class Real>
struct PressureTerm {
    static constexpr unsigned hooks = hook_stress;
    const Real* bulk;                ///< by body: K where the pressure is the grid's, else 0; null: nowhere [Pa]
    const CellPressure<Real>* cell;  ///< [tile][cell]

    MORAINE_HD bool on(const auto&) const { return bulk != nullptr; }

    template <class Case>
    MORAINE_HD void before_stress(const auto& of, const CellInWork<Case>& in, const auto& point, auto& dL, auto&,
                                  auto& out) const {
        const Real square = square_speed<Real, Case::dim>(point);
        if (double(square) > out.square_speed) out.square_speed = double(square);
        const Real own = bulk[of.p.body[point.slot]];
        if (own > Real(0)) out.work += take_cell(CellStep<Real>::of(of.cell_of(cell, in)), own, point, dL);
    }
};

}  // namespace moraine
