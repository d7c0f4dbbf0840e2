#pragma once
// Grid to particles on the device: how it is launched. Plain C++; which kernels a scene has is its KernelKey's.
//
// Two ways to the stress. Fused: gather and law in one kernel. Split: a gather that leaves dL = dt grad v per list
// entry, and one stress launch per material.
//
// A launch is any number of thread blocks >= 1: items are taken in turn up to a count that the device knows.
//
// Blocks in which light nodes limit an acceleration are few in most scenes: a kernel finds them, the gather passes them
// by, and an instance of it that asks every particle takes them.

#include <cstddef>
#include <vector>

#include "core/transfer/kernel_key.hpp"
#include "gpu/compile/kernel.hpp"
#include "gpu/kernels/g2p/gather_args.hpp"
#include "gpu/kernels/launch.hpp"

namespace moraine::gpu {

/// A material's law as its kernels are passed it: the bytes of its struct.
class LawValue {
  public:
    LawValue() = default;
    template <class Real>
    static LawValue of(const MaterialSpec& material);

    Argument argument() const { return {bytes_.data(), bytes_.size()}; }
    double inverse_density() const { return inverse_density_; }

  private:
    std::vector<std::byte> bytes_;
    double inverse_density_ = 0;  ///< [m3/kg]
};

/// One gather with what is fixed in a run. Not collective.
template <class Real, int Dim>
class GatherKernel {
  public:
    /// Without stress.
    explicit GatherKernel(const KernelKey& key);
    /// With the material's stress; ignores GatherArgs::gather, and GatherArgs::flip where particles have an affine
    /// field, for APIC and TPIC have none.
    GatherKernel(const KernelKey& key, const MaterialSpec& material, std::size_t number);
    /// Of its law, from now on.
    void take_strength(const MaterialSpec& material) { law_ = LawValue::of<Real>(material); }

    /// Of all chosen blocks that are not limited.
    void run(const View<Real, Dim>& view, const Chosen& chosen, const FluidGatherArgs<Real, Dim>& args,
             const Launch& launch) const;
    /// Of limited blocks alone: the same, and what their light nodes cannot bear is taken from their gradients.
    void run_limited(const View<Real, Dim>& view, const Chosen& limited, const FluidGatherArgs<Real, Dim>& args,
                     const Launch& launch) const;

  private:
    void launch(const Kernel& kernel, const View<Real, Dim>& view, const Chosen& chosen,
                const FluidGatherArgs<Real, Dim>& args, const Launch& launch) const;

    FluidGrid fluid_;
    bool fused_ = false;
    Kernel kernel_, limited_;
    LawValue law_;
};

/// Looks for the chosen blocks in which an acceleration is limited: sets LightArgs::limited of each, and lists them.
template <class Real, int Dim>
class FindLimited {
  public:
    FindLimited() = default;
    explicit FindLimited(const KernelKey& key);
    void operator()(const View<Real, Dim>& view, const Chosen& chosen, const GatherArgs<Real, Dim>& args,
                    const LimitedBlocks& found, const Launch& launch) const;

  private:
    Kernel list_, find_;
};

/// One material's stress update. Not collective.
template <class Real, int Dim>
class StressKernel {
  public:
    StressKernel(const KernelKey& key, const MaterialSpec& material, std::size_t number);
    void take_strength(const MaterialSpec& material) { law_ = LawValue::of<Real>(material); }
    void run(const View<Real, Dim>& view, const Chosen& chosen, const StressArgs<Real, Dim>& args,
             const Launch& launch) const;

  private:
    Kernel kernel_;
    LawValue law_;
};

}  // namespace moraine::gpu
