#pragma once
// Boxes of contiguous GIMP as a term: they follow the stretch of their particles (particle_update.hpp).

#include "core/grid/particle_update.hpp"
#include "core/terms/terms.hpp"

namespace moraine {

struct BoxTerm {
    static constexpr unsigned hooks = hook_stress;

    MORAINE_HD bool on(const auto& of) const { return of.p.log_stretch != nullptr; }

    template <class Real, int Dim>
    MORAINE_HD void before_stress(const auto& of, const auto&, const auto& point, Mat<Real, Dim>& dL, auto&,
                                  auto& out) const {
        auto& stretch = of.p.log_stretch[point.slot];
        const auto& half = of.context.half_size[of.p.body[point.slot]];
        bool held = false;
        for (int a = 0; a < Dim; ++a) {
            stretch[a] = advanced_stretch(stretch[a], dL(a, a));
            held = held || stretched_half(half[a], stretch[a]) > Real(0.5);
        }
        if (held) ++out.clamped;
    }
};

}  // namespace moraine
