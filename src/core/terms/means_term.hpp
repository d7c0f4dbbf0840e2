#pragma once
// Means of cells (volumetric.hpp) as a term: bodies that want it take their volumetric part from the cell.
//
// A cell's particles stay in one batch; those of a cell that holds more are gathered twice.

#include <cstdint>

#include "core/grid/volumetric.hpp"
#include "core/terms/gather_point.hpp"
#include "core/terms/terms.hpp"

namespace moraine {

template <class Real>
struct MeansTerm {
    static constexpr unsigned hooks = hook_cell | hook_stress | hook_after_cell;
    const std::uint8_t* averaged;  ///< by body: takes its volumetric part from the cell; null: none does

    template <class Case>
    struct State {
        VolumetricMean<Real> mean;  ///< of a crowded cell
    };

    MORAINE_HD bool on(const auto& of) const { return averaged && of.takes_gradient(); }

    /// gathered(f): calls f(slot, dL) for each particle of the cell.
    MORAINE_HD void at_cell(const auto& of, const auto& cell, auto& state, const auto& gathered) const {
        if (!cell.crowded()) return;
        state.mean = {};
        gathered([&](std::uint32_t s, const auto& dL) MORAINE_INLINE { add(of, state.mean, s, dL); });
        state.mean.finish();
    }

    MORAINE_HD void before_stress(const auto& of, const auto& cell, const auto& point, auto& dL, auto& state,
                                  auto&) const {
        if (cell.crowded()) take(of, state.mean, point.slot, dL);
    }

    MORAINE_HD void after_cell(const auto& of, const auto& cell, const std::uint32_t* slot, auto* dL, int n,
                               auto&) const {
        if (cell.crowded()) return;
        VolumetricMean<Real> mean;
        for (int k = 0; k < n; ++k) add(of, mean, slot[k], dL[k]);
        mean.finish();
        for (int k = 0; k < n; ++k) take(of, mean, slot[k], dL[k]);
    }

  private:
    MORAINE_HD void add(const auto& of, VolumetricMean<Real>& mean, std::uint32_t s, const auto& dL) const {
        if (averaged[of.p.body[s]]) mean.add(of.p.mass[s], trace(dL), of.p.stress[s].trace());
    }
    MORAINE_HD void take(const auto& of, const VolumetricMean<Real>& mean, std::uint32_t s, auto& dL) const {
        if (!averaged[of.p.body[s]]) return;
        set_trace(dL, mean.rate);
        set_trace(of.p.stress[s], mean.stress);
    }
};

}  // namespace moraine
