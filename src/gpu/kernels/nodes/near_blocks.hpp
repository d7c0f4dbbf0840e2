#pragma once
// Node blocks that a structure may touch. Few are, and the kernel that knows contact has twice the registers of one
// that does not: so they are solved by a launch of their own over this list, and all others as if nothing stood there.
//
// The list is in no order: nodes do not know of each other, and sums of what they give are exact.

#include <cuda_runtime_api.h>

#include "core/contact_field.hpp"
#include "core/gap_tiles.hpp"
#include "core/grid_views.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

/// Distance of nodes of blocks that the ground is not near, and more than that of any other [m].
inline constexpr double far_from_ground = 1e300;

struct NearBlocks {
    const std::int32_t* list;    ///< node blocks
    const std::uint32_t* count;  ///< of them
    const std::uint8_t* mark;    ///< by node block: it is one of them; null: the scene has no structures
};

/// What nodes want of the structures of a step; all of it on the device.
template <int Dim>
struct NodeContact {
    ContactField<Dim> field;
    GapTiles gaps;
    NearBlocks near;
};

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
