#pragma once
// The epochs of a run: the present one's lifetime, and the next one, made ahead from the blocks that all ranks hold
// (blocks/epoch_lifetime.hpp, blocks/next_epoch.hpp). Between steps; the tables go to the engine.
//
// request() gathers the keys of all occupied blocks, advance() makes tables from them once they are known, and begins
// their epoch when the old one is used up. Asynchronous where the engine leaves the host free.

#include <vector>

#include "balance/load.hpp"
#include "blocks/epoch_lifetime.hpp"
#include "blocks/next_epoch.hpp"
#include "comm/async_allgather.hpp"
#include "comm/host_groups.hpp"
#include "engine/engine.hpp"
#include "simulation/run_counts.hpp"

namespace moraine {

template <class Real, int Dim>
class RunEpochs {
  public:
    /// All must outlive it; owner_at and prepare as for NextEpoch. Not collective.
    RunEpochs(const DomainBlocks<Dim>& domain, const Stencil& stencil, const Comm& comm, const HostOfRank& hosts,
              RunCounts& counts, typename NextEpoch<Dim>::OwnerAt owner_at, typename NextEpoch<Dim>::Prepare prepare)
        : comm_(comm),
          hosts_(hosts),
          counts_(counts),
          next_(domain, stencil, comm.rank(), std::move(owner_at), std::move(prepare)),
          keys_(comm) {}

    EpochLifetime& lifetime() { return lifetime_; }
    const EpochLifetime& lifetime() const { return lifetime_; }
    NextEpoch<Dim>& next() { return next_; }
    const NextEpoch<Dim>& next() const { return next_; }

    /// Whether the next epoch is made asynchronously. The same on all ranks.
    void set_async(bool async) { async_ = async; }
    /// Whether kernels must have ended before it asks for blocks.
    bool must_synchronize(const Engine<Real, Dim>& engine) const {
        return !(async_ && engine.device().leaves_host_free);
    }
    /// Whether the present one is used up, or the next one is to be begun meanwhile.
    bool wants_next() const {
        return lifetime_.is_used_up() || (async_ && lifetime_.state() == EpochLifetime::State::in_guard_layer);
    }

    /// Of an epoch that begins now with these blocks; owners are the ranks that hold them. Not collective.
    EpochTables<Dim> make(const std::vector<BlockLoad>& loads);
    /// Notes what crosses hosts in an epoch that begins now. Not collective.
    EpochTables<Dim> counted(EpochTables<Dim> tables);
    /// A step further with the next one; begins it when the old one is used up. Collective.
    void advance(Engine<Real, Dim>& engine);
    /// What would have been the next one is none. Collective.
    void forget_next() { keys_.finish(); }

  private:
    void request(Engine<Real, Dim>& engine);
    void start_next();
    void renew(Engine<Real, Dim>& engine);

    const Comm& comm_;
    const HostOfRank& hosts_;
    RunCounts& counts_;
    EpochLifetime lifetime_;
    NextEpoch<Dim> next_;
    AsyncAllgather<Key> keys_;  ///< occupied blocks of all ranks, that the next epoch is made from
    bool async_ = false;
};

}  // namespace moraine
