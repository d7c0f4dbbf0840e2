#pragma once
// What fluids take from the grid on the device: means of nodes (core/fluid/pressure_smoothing.hpp,
// core/fluid/particle_shifting.hpp), the grid's pressure (core/fluid/grid_pressure.hpp), and the volumes of
// over-filling.

#include <cmath>

#include "core/data/exact_sum.hpp"
#include "core/transfer/method.hpp"
#include "gpu/engine_kernels.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
struct FluidState {
    NodeMean mean = NodeMean::none;  ///< of this step: in the last lane of the sums
    Array<FluidTerms<Real>> terms;   ///< by body
    FluidTerms<Real> first{};        ///< of the first one
    PressureState<Real, Dim> pressure;
    Array<ExactSum> volumes;  ///< of over-filling: above, all

    /// Where the pressure is the grid's and nothing is smoothed or shifted, terms are zero.
    /// at_surfaces: structures act there.
    void start(const Method<Host, Real, Dim>& method, std::size_t bodies, bool at_surfaces) {
        if (method.grid_bulk()) pressure.start(method.grid_bulk(), bodies, at_surfaces);
        if (!takes_means(method)) return;
        std::vector<FluidTerms<Real>> of_body(bodies);
        if (method.fluid()) of_body.assign(method.fluid(), method.fluid() + bodies);
        first = of_body.front();
        terms.assign(of_body);
    }
    bool shifts() const { return mean == NodeMean::volume; }
    MeanScale<Real> mean_scale(const Method<Host, Real, Dim>& method) const {
        return {method.cell, shifts(), method.grid_bulk() != nullptr};
    }
    NodeFluid<Real, Dim> at_nodes(const Method<Host, Real, Dim>& method, double cell) const {
        return {shifts(), method.capacity, static_cast<Real>(std::pow(cell, -Dim))};
    }
    /// several: the scene has several materials.
    FluidArgs<Real> args(const Method<Host, Real, Dim>& method, bool several, const SurfaceSpace& surfaces) const {
        if (!takes_means(method)) return {};
        return {several ? terms.data() : nullptr, first, shifts(), surfaces};
    }
};

}  // namespace moraine::gpu
