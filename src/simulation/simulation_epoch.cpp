// Between steps: the owners of blocks, and how long an epoch lasts. A plan is rebalance.hpp's, what blocks
// weigh measured_loads.hpp's, how long an epoch holds blocks/epoch_lifetime.hpp's.

#include <algorithm>
#include <chrono>
#include <utility>

#include "host/host_engine.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

template <class Real, int Dim>
void Simulation<Real, Dim>::balance() {
    if (engine_->leads()) return;  // until it stands still
    const bool some_come = supply_.next() <= clock_.time;
    rebalance_.want(clock_.step);
    if (!some_come && rebalance_.is_to_begin(clock_.step, epoch_, agreed_.moved)) begin_check();
    if (rebalance_.is_under_way()) continue_check(some_come);
    if (rebalance_.is_under_way()) return;
    if (some_come) return admit();
    const bool used_up = epoch_.is_used_up();
    const bool wants_next = used_up || (async_ && epoch_.state() == EpochLifetime::State::in_guard_layer);
    if (must_synchronize() && wants_next) synchronize();
    phases_.time(Phase::balance, [&] {
        const bool under_way = keys_.under_way() || next_epoch_.under_way();
        start_next_epoch();
        if (wants_next && (!under_way || epoch_.next_is_stale())) request_next_epoch();
        if (used_up) start_next_epoch(), renew_epoch();
    });
}

/// The binned state, with nothing under way.
template <class Real, int Dim>
void Simulation<Real, Dim>::synchronize() {
    bin();
    phases_.time(Phase::agree, [&] { engine_->synchronize(); });
}

template <class Real, int Dim>
std::vector<BlockLoad> Simulation<Real, Dim>::block_loads() {
    bin();
    return loads_.gather(engine_->block_counts(loads_.weighs_cells()));
}

/// Notes what crosses hosts in an epoch that begins now.
template <class Real, int Dim>
EpochTables<Dim> Simulation<Real, Dim>::counted(EpochTables<Dim> tables) {
    counts_.blocks_between_hosts = 0;
    for (const PeerHalo& peer : tables.peers)
        if (hosts_[peer.rank] != hosts_[comm_.rank()])
            counts_.blocks_between_hosts += static_cast<std::int64_t>(peer.send.block.size());
    return tables;
}

/// This rank's part of a topology made from what is occupied now; owners are the ranks that hold the blocks.
template <class Real, int Dim>
EpochTables<Dim> Simulation<Real, Dim>::next_epoch(const std::vector<BlockLoad>& loads) {
    std::vector<OccupiedBlock> occupied;
    for (const BlockLoad& load : loads) occupied.push_back({load.key, load.owner});
    epoch_.begin();
    return next_epoch_.make(std::move(occupied));
}

/// With particles that were put into the host's share.
template <class Real, int Dim>
void Simulation<Real, Dim>::begin_epoch(const BinnedBlocks& binned) {
    engine_->begin_epoch(counted(next_epoch(loads_.gather(counts_of(patch(), binned, false)))), HostShare{binned});
    engine_->refresh_memory(false);
}

/// Begins to make the next epoch from what the last binning found occupied.
template <class Real, int Dim>
void Simulation<Real, Dim>::request_next_epoch() {
    keys_.finish();
    keys_.start(engine_->block_counts(false).key);
    epoch_.begin_next();
}

/// The next epoch is made once all ranks' blocks are known: two steps later, or at once where it is wanted now.
template <class Real, int Dim>
void Simulation<Real, Dim>::start_next_epoch() {
    if (!keys_.under_way()) return;
    const bool now = !async_ || epoch_.is_used_up();
    if (auto all = now ? keys_.finish() : keys_.advance())
        next_epoch_.start(std::move(all->rows), std::move(all->counts), async_);
}

/// Takes the epoch that was made ahead.
template <class Real, int Dim>
void Simulation<Real, Dim>::renew_epoch() {
    if (std::optional<EpochTables<Dim>> tables = next_epoch_.take()) {
        engine_->begin_epoch(counted(std::move(*tables)), KeptBlocks{});
        ++counts_.epochs;
    }
    epoch_.begin_made_ahead();
    engine_->refresh_memory(false);
}

template <class Real, int Dim>
RunCounts Simulation<Real, Dim>::counts_so_far() const {
    RunCounts counts = counts_;
    const Traffic traffic = engine_->traffic();
    counts.halo_bytes = traffic.halo_bytes;
    counts.crossed_particles = traffic.crossed_particles;
    return counts;
}

/// The loads of now are on their way to all ranks, unless all is well without.
template <class Real, int Dim>
void Simulation<Real, Dim>::begin_check() {
    ImbalanceCheck found;
    if (loads_.is_balanced(trigger_, clock_.step, found)) return rebalance_.skip(std::move(found));
    if (must_synchronize()) synchronize();
    phases_.time(Phase::balance, [&] {
        const BlockCounts mine = engine_->block_counts(loads_.weighs_cells());
        loads_.refine(mine, clock_.step, phases_.computing());
        const std::int64_t most = -comm_.max(-std::min(most_, mine.capacity));
        ImbalanceCheckInput input{{}, clock_.round, most, loads_.unit()};
        loads_.take_times(clock_.step, input.times);
        keys_.finish();  // what would have been the next epoch
        rebalance_.begin(clock_.step, loads_.of(mine), std::move(input));
        epoch_.begin_next();
    });
}

/// What is due is taken: blocks move, or all stays. now: it cannot wait.
template <class Real, int Dim>
void Simulation<Real, Dim>::continue_check(bool now) {
    std::optional<EpochTables<Dim>> tables;
    phases_.time(Phase::balance, [&] {
        rebalance_.advance(clock_.step, agreed_.making != 0, now || epoch_.is_used_up() || epoch_.next_is_used_up());
        if (rebalance_.state() == Rebalance<Dim>::State::due) tables = rebalance_.take();
    });
    if (!tables) return;
    synchronize();
    phases_.time(Phase::balance, [&] { repartition(std::move(*tables)); });
}

/// Begins the epoch that was planned, and brings blocks to their owners in it: also those that were empty then.
template <class Real, int Dim>
void Simulation<Real, Dim>::repartition(EpochTables<Dim> tables) {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<std::int32_t> of_mine = next_epoch_.owners_of(engine_->block_counts(false).key);
    const BlockMoveCount moved = engine_->begin_epoch(counted(std::move(tables)), MovedBlocks{of_mine});
    engine_->refresh_memory(false);
    epoch_.begin_made_ahead();
    counts_.migrated_particles += moved.particles;
    counts_.migrated_blocks += moved.blocks;
    ++counts_.repartitions;
    ++clock_.round;
    loads_.begin_again(clock_.step);
    const double seconds = comm_.max(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    rebalance_.learn(seconds);
}

template class Simulation<float, 2>;
template class Simulation<float, 3>;
template class Simulation<double, 2>;
template class Simulation<double, 3>;

}  // namespace moraine
