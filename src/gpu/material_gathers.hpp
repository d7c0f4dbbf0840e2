#pragma once
// The gathers of a scene of several materials that go by material (core/transfer/kernel_key.hpp): most blocks
// hold particles of one material, and go through that one's kernel, gather and stress at once. The rest, blocks of
// several and blocks with light nodes, is left to the engine's gather without stress.
//
// Blocks do not know of each other, so the kernels of a part run concurrently: what is of one material on streams of
// lower priority than the rest, which is few blocks in most scenes, and several launches that wait for one another.

#include <array>
#include <vector>

#include "gpu/kernels/g2p/sort_blocks.hpp"
#include "gpu/memory/pinned_bytes.hpp"
#include "gpu/memory/pool_array.hpp"
#include "gpu/memory/stream.hpp"

namespace moraine::gpu {

/// Where the rest's kernels go: all but those of limited blocks, and these. The same stream twice: one after the other.
using Lanes = std::array<Launch, 2>;

template <class Real, int Dim>
class MaterialGathers {
  public:
    using V = View<Real, Dim>;

    /// material_of: by body, on the device; it must outlive this. Not collective.
    MaterialGathers(const Scene& scene, const KernelKey& key, const std::uint16_t* material_of);

    /// Of a stage that begins.
    void take_strengths(const std::vector<MaterialSpec>& materials) {
        for (std::size_t k = 0; k < gather_.size(); ++k) gather_[k].take_strength(materials[k]);
    }

    /// Capacity for `own` blocks; parts: 1 if there is no boundary. Earlier lists are lost. stream: that of the steps.
    void open(std::size_t own, int parts, cudaStream_t stream);
    /// Sets the thread blocks of later launches by the last known lengths of the lists: any number is right. Whether
    /// one has changed.
    bool choose_grids();

    /// Sorts the chosen blocks of a part: 0 is the boundary, 1 the interior. concurrently: with what launch.stream gets
    /// until gather(). Asynchronous, as all that follows.
    void sort(int part, const V& view, const Chosen& chosen, bool concurrently, const Launch& launch);

    struct Rest {
        Chosen chosen;
        Lanes lanes;
    };
    /// Gathers the sorted blocks that are of one material. Returns the rest, the limited blocks with it; null: there
    /// are none.
    Rest gather(int part, const V& view, const FluidGatherArgs<Real, Dim>& args, const Chosen* limited,
                const Launch& launch);
    /// What the first lane gets from here on waits for the second.
    void meet(const Lanes& lanes);
    /// What the stream gets from here on waits for gather().
    void finish(int part, cudaStream_t stream);

  private:
    std::size_t lists_of_part() const { return gather_.size() + 1; }
    std::size_t place_of(int part) const { return parts_ == 1 ? 0 : static_cast<std::size_t>(part); }
    SortedBlocks lists(int part) const;
    int grid(int part, int list, const Launch& launch) const;

    const std::uint16_t* material_of_;
    std::vector<GatherKernel<Real, Dim>> gather_;  ///< by material
    PoolArray<std::int32_t> blocks_;
    Array<std::uint32_t> counts_;
    PoolArray<std::uint16_t> list_of_;
    PinnedBytes told_;                 ///< lengths of both parts' lists; all ones: not known yet
    std::uint32_t* tells_ = nullptr;   ///< the same as the device sees them
    std::vector<std::uint32_t> grid_;  ///< of launches over them; 0: not known yet
    std::size_t capacity_ = 0;
    int parts_ = 1;
    Stream of_material_[2][2]{{Stream{Stream::Rank::apart_ahead}, Stream{Stream::Rank::apart_ahead}},
                              {Stream{Stream::Rank::apart}, Stream{Stream::Rank::apart}}};  ///< [part][even, odd]
    Stream sorting_{Stream::Rank::apart_ahead}, limited_{Stream::Rank::apart_ahead};
    Event begun_, sorted_, ready_, met_, done_[2];
};

}  // namespace moraine::gpu
