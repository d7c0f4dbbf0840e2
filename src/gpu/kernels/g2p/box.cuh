#pragma once
// Boxes of contiguous GIMP (core/terms/box_term.hpp) on the device: they follow the stretch of their particles.

#include "gpu/kernels/g2p/gather_case.cuh"

namespace moraine::gpu {

/// Half-size of a particle's box along an axis [cells]; stretch: its row, where the scene has one.
template <class Real, int Dim>
__device__ __forceinline__ Real half_size(const View<Real, Dim>& v, std::uint32_t body, const Row<Real>& stretch,
                                          int a) {
    const Real half = v.context.half_size[body][a];
    return held_half(v.p.log_stretch ? stretched_half(half, stretch.e[a]) : half);
}

template <class Case>
struct BoxTerm {
    static constexpr unsigned hooks = Case::Shape::sized ? hook_rate : 0u;
    struct Shared {};

    MORAINE_TEAM void on_rate(const auto& in, const auto& point, const auto&, auto& sums, const auto&, auto& tally) {
        using Real = typename Case::Real;
        if (!in.v.p.log_stretch) return;
        Row<Real> stretch = point.stretch();
        bool held = false;
#pragma unroll
        for (int a = 0; a < Case::dim; ++a) {
            stretch.e[a] = advanced_stretch(stretch.e[a], in.g.dt * in.v.context.inverse_cell * sums.gradient[a][a]);
            held = held || stretched_half(in.v.context.half_size[point.body][a], stretch.e[a]) > Real(0.5);
        }
        store_row(in.v.p.log_stretch + point.slot, stretch);
        if (held) ++tally.clamped;
    }
};

}  // namespace moraine::gpu
