#pragma once
// The halo on devices: unsummed tiles travel as comm/halo.hpp has it, packed and unpacked by kernels.
//
// A message: its head, one byte per tile of the list (HaloTile), then node_sums reals for each node of those that come,
// one more where they have a mean, padded to 16 bytes, then the gaps of the nodes of those that are there to each
// structure near their block, where gaps are asked for. A kernel with a thread block per peer finds where each tile
// stands; then a thread block per tile copies. The nodes read foreign tiles as those of ghost blocks.

#include "core/data/grid_views.hpp"
#include "gpu/exchange/routes.hpp"
#include "gpu/kernels/gaps/gaps.hpp"
#include "gpu/memory/stream.hpp"
#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

/// What a message says of a tile: there is none; it comes; it comes, and is of a block that sleeps; such a one that is
/// as it came before, and does not come again.
enum class HaloTile : std::uint8_t { none, awake, asleep, kept };

/// Who sleeps, where the scene has sleepers.
struct HaloSleepers {
    std::uint8_t* asleep = nullptr;      ///< own, then ghosts; null: nobody
    const std::uint8_t* kept = nullptr;  ///< own: the tile is as it was sent before in this epoch; null: none
};

template <class Real, int Dim>
class DeviceHalo {
  public:
    /// with_mean: nodes have one more real, the force quad's last lane (NodeMean).
    DeviceHalo(std::unique_ptr<Transport> transport, bool with_mean)
        : transport_(std::move(transport)), with_mean_(with_mean) {}

    /// For an epoch, with capacity for gaps to that many structures; between two rounds of the stream of the steps.
    /// Collective.
    void open(const EpochTables<Dim>& tables, std::size_t structures, cudaStream_t stream);

    /// gaps: null in rounds without. tile_side: nodes of a tile along an axis. Counts the bytes. On one stream;
    /// asynchronous but for what the transport waits for.
    void start(const Route& send, const TileView<Real>& grid, const DeviceGaps<Dim>* gaps, const HaloSleepers& sleepers,
               int tile_side, Counters* counters, cudaStream_t stream);
    void post() { transport_->post(); }
    /// Puts foreign tiles in place: tile g is that of ghost g; tile_of: own blocks, then ghosts.
    void finish(const Route& receive, const TileView<Real>& grid, const DeviceGaps<Dim>* gaps,
                const HaloSleepers& sleepers, std::int32_t* tile_of, int own, int tile_side, cudaStream_t stream);

  private:
    template <bool Mean>
    void pack(const Route& send, const TileView<Real>& grid, const DeviceGaps<Dim>* gaps, const HaloSleepers& sleepers,
              int tile_side, Counters* counters, cudaStream_t stream);
    template <bool Mean>
    void unpack(const Route& receive, const TileView<Real>& grid, const DeviceGaps<Dim>* gaps,
                const HaloSleepers& sleepers, std::int32_t* tile_of, int own, int tile_side, cudaStream_t stream);

    std::unique_ptr<Transport> transport_;
    bool with_mean_;
    PoolArray<std::uint32_t> place_;      ///< by tile of the way under work: nodes before it in its message
    PoolArray<std::uint32_t> gap_place_;  ///< gaps before those of the tile
};

}  // namespace moraine::gpu
