#pragma once
// Node blocks that a structure may touch. Few are, and the kernel that knows contact has twice the registers of one
// that does not: so they are solved by a launch of their own over this list, and all others as if nothing stood there.
//
// The list is in no order: nodes do not know of each other, and sums of what they give are exact.

#include <cuda_runtime_api.h>

#include "gpu/kernels/nodes/node_work.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

template <int Dim>
class DeviceNearBlocks {
  public:
    void forget() { known_ = false; }
    /// Those of this epoch's node blocks, found anew where a structure moves. field: on the device; origin: of the
    /// stencil. Asynchronous.
    NearBlocks find(const BlockTable<Dim>& table, const ContactField<Dim>& field, int origin, bool moves,
                    cudaStream_t stream);

  private:
    Array<std::int32_t> list_;
    Array<std::uint32_t> count_;
    Array<std::uint8_t> mark_;
    bool known_ = false;  ///< in this epoch
};

}  // namespace moraine::gpu
