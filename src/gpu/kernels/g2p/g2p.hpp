#pragma once
// Grid to particles on the device: how it is launched. Plain C++; the kernels are compiled elsewhere, one file per
// precision, dimension and kind.
//
// Two ways to the stress. Fused: gather and law in one kernel, for what most runs are: hats or quadratic splines, with
// splines also an affine field, all of a step in one round (USL), one material. Split: a gather that leaves
// dL = dt grad v per list entry, and one stress launch per material. Which way a scene goes is decided once; the two
// differ in rounding. Fluids that take more from the grid have instances of both (fluid.cuh).
//
// A launch is any number of thread blocks >= 1: items are taken in turn up to a count that the device knows.
//
// Blocks in which light nodes limit an acceleration are few in most scenes: a kernel finds them, the gather passes them
// by, and an instance of it that asks every particle takes them.

#include <memory>

#include "comm/fused_gather.hpp"
#include "core/scene_spec.hpp"
#include "gpu/kernels/g2p/gather_args.hpp"
#include "gpu/kernels/launch.hpp"

namespace moraine::gpu {

/// One gather kernel with what is fixed in a run. Not collective.
template <class Real, int Dim>
class GatherKernel {
  public:
    virtual ~GatherKernel() = default;
    /// Of all chosen blocks that are not limited.
    virtual void run(const View<Real, Dim>& view, const Chosen& chosen, const FluidGatherArgs<Real, Dim>& args,
                     const Launch& launch) const = 0;
    /// Of limited blocks alone: the same, and what their light nodes cannot bear is taken from their gradients.
    virtual void run_limited(const View<Real, Dim>& view, const Chosen& limited, const FluidGatherArgs<Real, Dim>& args,
                             const Launch& launch) const = 0;
};

/// Looks for the chosen blocks in which an acceleration is limited: sets LightArgs::limited of each, and lists them.
template <class Real, int Dim>
using FindLimited = void (*)(const View<Real, Dim>& view, const Chosen& chosen, const GatherArgs<Real, Dim>& args,
                             const LimitedBlocks& found, const Launch& launch);

template <class Real, int Dim>
FindLimited<Real, Dim> choose_find_limited(moraine::Shape shape);

/// One material's stress update. Not collective.
template <class Real, int Dim>
class StressKernel {
  public:
    virtual ~StressKernel() = default;
    virtual void run(const View<Real, Dim>& view, const Chosen& chosen, const StressArgs<Real, Dim>& args,
                     const Launch& launch) const = 0;
};

/// Gather without stress; averages: some bodies take their volumetric part from the cell (core/volumetric.hpp).
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_gather(moraine::Shape shape, bool affine, bool averages);

/// Gather with the material's stress; ignores GatherArgs::gather. For scenes that fuses() names
/// (comm/fused_gather.hpp). affine: of quadratic splines, whatever `shape` says; GatherArgs::flip is ignored then, for
/// APIC and TPIC have none.
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fused_gather(const MaterialSpec& material, moraine::Shape shape,
                                                           bool affine);

/// The same for a scene, or a material of quadratic splines, with fluid terms.
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fluid_gather(moraine::Shape shape, bool affine);
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fused_fluid_gather(const MaterialSpec& material, bool affine);

/// The same for scenes whose pressure is the grid's; quadratic splines alone.
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_pressure_gather(bool affine);
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fused_pressure_gather(const MaterialSpec& material, bool affine);

template <class Real, int Dim>
std::unique_ptr<StressKernel<Real, Dim>> make_stress(const MaterialSpec& material);

}  // namespace moraine::gpu
