#pragma once
// Migration between devices: particles that walk into a block of another rank.
//
// A message: its head with the count, then one record per particle (gpu/exchange/particle_record.hpp) by source block,
// exit and list order. At the other side they become the outgoing particles of ghost blocks behind the own ones, in
// that order, and binning goes on by its one rule; their rows go to the free slots at the end of memory.
//
// Buffers cannot overflow: who leaves a block stood in a cell beside the face, for no step is as long as a cell. How
// many stand in such cells, of a block and of all that one rank shares with another (the migration bound), travels with
// each step's agreement, before the outgoing particles do. When it outgrows the capacities, all ranks make larger ones.

#include "engine/agreement.hpp"
#include "gpu/exchange/particle_record.hpp"
#include "gpu/exchange/routes.hpp"
#include "gpu/kernels/binning/binning.hpp"
#include "gpu/memory/stream.hpp"
#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

template <int Dim>
class DeviceMigration {
  public:
    explicit DeviceMigration(std::unique_ptr<Transport> transport) : transport_(std::move(transport)) {}

    /// With capacities for the migration bound of the epoch before; the first ones are made by expect(). The migration
    /// bound may be counted on the stream behind it. Collective.
    void begin_epoch(const EpochTables<Dim>& tables, cudaStream_t stream);
    /// Makes space for a migration bound (the same on all ranks) whose records take `record` bytes. Collective.
    void expect(const MigrationBound& bound, std::size_t record);
    /// Particles that may arrive in one step.
    std::size_t most_incoming() const { return most_incoming_; }

    /// Makes counters.crowd no less than this rank's. Not again before finish() or begin_epoch(). Asynchronous.
    void count_migration_bound(const Route& send, const BlockTable<Dim>& table, const ListView<Dim>& list,
                               Counters* counters, cudaStream_t stream);
    /// Sends the outgoing particles that are collected. On one stream, as is finish().
    void start(const Route& send, const Binning<Dim>& binning, const RecordLayout& layout, Counters* counters,
               cudaStream_t stream);
    void post() { transport_->post(); }
    /// Takes the incoming particles in, as outgoing ones of ghosts; own ones end at binning.list.first[own]. The
    /// migration bound may be counted anew.
    void finish(const Route& receive, const Binning<Dim>& binning, const RecordLayout& layout, Counters* counters,
                cudaStream_t stream);

  private:
    struct Peer {
        int rank;
        std::size_t tiles_out, tiles_in;
    };
    std::size_t most_from(std::size_t tiles) const;

    std::unique_ptr<Transport> transport_;
    std::vector<Peer> peers_;
    PoolArray<std::uint32_t> place_;   ///< by tile: outgoing particles of this peer before its own
    PoolArray<std::uint32_t> facing_;  ///< by peer: particles that can leave to it; zeros before they are counted
    MigrationBound migration_bound_;   ///< what the capacities are made for; 0: there are none yet
    std::size_t record_ = 0;
    std::size_t most_incoming_ = 0;
};

}  // namespace moraine::gpu
