#pragma once
// Absorbing ends on the device (core/nodes/absorbing_ends.hpp): what they give is added to tiles between the halo and
// the nodes. Where they are is found once per epoch, by the host.

#include <cuda_runtime.h>

#include <span>

#include "core/nodes/absorbing_ends.hpp"
#include "gpu/kernels/view.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
class DeviceEnds {
  public:
    /// measured: must outlive it.
    explicit DeviceEnds(const EndNodes<Dim>& measured) : measured_(measured) {}

    /// An epoch has begun, or other faces absorb.
    void forget() { laid_ = false; }
    /// Those of this epoch. absorbs: by face; origin: of the stencil. Waits for the stream where they are found anew.
    void find(const Walls<Real, Dim>& walls, const bool (&absorbs)[Dim][2], int origin,
              std::span<const Vec<std::int32_t, Dim>> node_blocks, cudaStream_t stream);
    /// In a round that has forces. width, origin: of the stencil. Asynchronous.
    void act(const View<Real, Dim>& view, int width, int origin, const NodeRound<Real, Dim>& round,
             const Quantum& quantum, cudaStream_t stream) const;

  private:
    const EndNodes<Dim>& measured_;
    bool laid_ = false;
    Array<EndSite<Real, Dim>> sites_;
    Array<EndGift<Dim>> gifts_;
};

}  // namespace moraine::gpu
