#pragma once
// What an epoch fixes on the device: its tables, the blocks' lists, tiles and nodes, and the tables of the next epoch.
//
// The next tables are copied during a step, by another thread, over those of two epochs before: kernels that read them
// have ended, because new tables are asked for by a report of the present ones.

#include <optional>

#include "blocks/epoch.hpp"
#include "core/data/quad.hpp"
#include "gpu/exchange/block_moves.hpp"
#include "gpu/exchange/exchange.hpp"
#include "gpu/kernels/binning/lists.hpp"
#include "gpu/memory/device_tables.hpp"
#include "gpu/memory/pool_array.hpp"
#include "gpu/memory/stream.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
struct EpochState {
    /// For the current device. width: of the stencil [nodes]; several: there are other ranks.
    EpochState(int width, bool several);

    /// Copies tables that take() will get. Waits for the copy alone.
    void prepare(const EpochTables<Dim>& tables);
    /// Makes tables those of the epoch; exchange: null where the rank is alone. What others keep of an epoch follows.
    void take(EpochTables<Dim> tables, Exchange<Real, Dim>* exchange);
    /// Capacity for these tiles, and an eighth more ghosts than there are; what was in them is lost. Asynchronous.
    void make_tiles(std::size_t tiles, cudaStream_t stream);
    /// Memory for the nodes. Asynchronous.
    void make_nodes(cudaStream_t stream);
    /// Whether tiles must be made for so many occupied blocks, or can be fewer; and how many then: space to spare for
    /// a flow that spreads and occupies a few blocks more in every epoch.
    bool wants_tiles(std::size_t blocks) const;
    std::size_t tiles_for(std::size_t blocks) const;
    std::size_t tile_quads() const { return static_cast<std::size_t>(2 * power<Dim>(tile_side(width))); }
    /// Occupied blocks. Synchronous.
    std::vector<ListRange> occupied() const;
    std::size_t own() const { return tables.own.size(); }

    const int width;
    const bool several;
    int device = 0;
    EpochTables<Dim> tables;        ///< the host's
    Tables<Dim> table, next_table;  ///< on the device
    ListTables next_list_tables;
    Routes next_routes;
    std::int64_t prepared = 0;                ///< serial of the tables that the next ones hold; 0: of none
    std::optional<EpochTables<Dim>> pending;  ///< of the epoch that begins with the next binning
    Stream upload{Stream::Rank::apart};
    Lists<Dim> lists;
    PoolArray<Quad<Real>> tiles, nodes;
    PoolArray<std::int32_t> node_of;  ///< 0, 1, 2, ...
    std::size_t tile_capacity = 0;
    std::size_t ghost_capacity = 0;
    std::uint64_t layout = 0;  ///< serial of what launches depend on besides columns: tables, memory
};

}  // namespace moraine::gpu
