#pragma once
// Tractions (core/terms/traction_term.hpp) on the device: F of the soil that they may act on, and what they do.

#include "gpu/kernels/g2p/gather_case.cuh"
#include "gpu/kernels/loads/load_rows.cuh"

namespace moraine::gpu {

template <class Case>
struct LoadTerm {
    static constexpr unsigned hooks = Case::loads ? hook_rate : 0u;
    struct Shared {};

    MORAINE_TEAM void on_rate(const auto& in, const auto& point, const auto&, auto& sums, const auto&, auto&) {
        using Real = typename Case::Real;
        constexpr int Dim = Case::dim;
        const Mat<Real, Dim> dL = tensor_of<Dim>(in.g.dt * in.v.context.inverse_cell, sums.gradient);
        DeformationRows<Real, Dim> rows(in.v.p, point.slot);
        Mat<Real, Dim> change = rows.get();
        deform(dL, change);
        rows.set(change);
        rows.store(in.v.p, point.slot);
        if (!in.g.loads.loaded[in.work.block]) return;
        const ParticleLoad<Real, Dim> load = in.g.loads.of[point.entry];
        if (!acts(load)) return;
        double did[Dim + 1] = {};
#pragma unroll
        for (int a = 0; a < Dim; ++a) {
            did[1 + a] = double(in.g.dt) * double(load.force[a]);
            did[0] += did[1 + a] * double(sums.velocity[a]);
#pragma unroll
            for (int b = 0; b < Dim; ++b) did[0] += double(load.couple(a, b)) * double(dL(a, b));
        }
        add_together(in.g.loads.sums->of, in.g.quantum, did);
    }
};

}  // namespace moraine::gpu
