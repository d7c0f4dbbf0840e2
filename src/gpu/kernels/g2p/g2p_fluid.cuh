#pragma once
// The gathers for fluids that smooth pressures or shift particles (fluid.cuh), with stress and without.

#include "gpu/kernels/g2p/g2p_fused.cuh"
#include "gpu/kernels/g2p/g2p_split.cuh"

namespace moraine::gpu {

/// Another material may take means of cells: it is asked at run time, but for boxes and cubic splines, where registers
/// would spill (the program refuses such scenes on devices).
template <class Real, int Dim, class Shape>
std::unique_ptr<GatherKernel<Real, Dim>> fluid_gather(bool affine) {
    constexpr bool averages = !Shape::sized && Shape::width < 4;
    if (affine) return std::make_unique<SplitKernel<Real, Dim, Shape, true, averages, FluidGrid::means>>();
    return std::make_unique<SplitKernel<Real, Dim, Shape, false, averages, FluidGrid::means>>();
}

template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fluid_gather(moraine::Shape shape, bool affine) {
    switch (shape) {
        case moraine::Shape::linear:
            return fluid_gather<Real, Dim, Linear>(affine);
        case moraine::Shape::quadratic:
            return fluid_gather<Real, Dim, Quadratic>(affine);
        case moraine::Shape::cubic:
            return fluid_gather<Real, Dim, Cubic>(affine);
        default:
            return fluid_gather<Real, Dim, Gimp>(affine);
    }
}

/// Quadratic splines alone (comm/fused_gather.hpp).
template <class Real, int Dim, FluidGrid Fluid>
std::unique_ptr<GatherKernel<Real, Dim>> fused_fluid_kernel(const MaterialSpec& material, bool affine) {
    using Result = std::unique_ptr<GatherKernel<Real, Dim>>;
    return with_law<Real>(material.law, material.parameters.data(), [&](const auto& law) -> Result {
        using Law = std::decay_t<decltype(law)>;
        if constexpr (is_fluid<Law>()) {
            if (affine)
                return std::make_unique<FusedKernel<Real, Dim, Quadratic, Law, true, false, Fluid>>(law,
                                                                                                    material.density);
            return std::make_unique<FusedKernel<Real, Dim, Quadratic, Law, false, false, Fluid>>(law, material.density);
        }
        return nullptr;  // no scene asks for it
    });
}

template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fused_fluid_gather(const MaterialSpec& material, bool affine) {
    return fused_fluid_kernel<Real, Dim, FluidGrid::means>(material, affine);
}

template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fused_pressure_gather(const MaterialSpec& material, bool affine) {
    return fused_fluid_kernel<Real, Dim, FluidGrid::pressure>(material, affine);
}

template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_pressure_gather(bool affine) {
    if (affine) return std::make_unique<SplitKernel<Real, Dim, Quadratic, true, false, FluidGrid::pressure>>();
    return std::make_unique<SplitKernel<Real, Dim, Quadratic, false, false, FluidGrid::pressure>>();
}

}  // namespace moraine::gpu
