#pragma once
// All that an engine has only where there are other ranks: their transports, and what travels on them.

#include "comm/point_to_point.hpp"
#include "gpu/exchange/block_moves.hpp"
#include "gpu/exchange/halo.hpp"
#include "gpu/exchange/migration.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
struct Exchange {
    /// with_mean: of the halo's nodes. Collective.
    Exchange(const Comm& c, const TransportFactory& transports, bool with_mean)
        : comm(c),
          halo(transports.make(11), with_mean),
          migration(transports.make(12)),
          moves(c, transports.make(13)),
          activity(c, 5) {}

    /// For an epoch whose routes are there, between two rounds, on the stream of the steps. Collective.
    void open(const EpochTables<Dim>& tables, std::size_t structures, cudaStream_t steps) {
        halo.open(tables, structures, steps);
        migration.begin_epoch(tables, steps);
    }

    const Comm& comm;
    Routes routes;
    DeviceHalo<Real, Dim> halo;
    DeviceMigration<Dim> migration;
    BlockMoves moves;
    PointToPoint activity;  ///< of blocks, at sleep checks

    Stream stream{Stream::Rank::ahead};  ///< of the boundary, the halo and migration, concurrent with the step's
    Event binned, boundary_summed, halo_here, solved, boundary_moved, arrived;
};

}  // namespace moraine::gpu
