// Between steps: the owners of blocks. A plan is rebalance.hpp's, what blocks weigh measured_loads.hpp's, how long an
// epoch holds and what the next one is run_epochs.hpp's.

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
    if (!some_come && rebalance_.is_to_begin(clock_.step, epochs_.lifetime(), agreement().moved)) begin_check();
    if (rebalance_.is_under_way()) continue_check(some_come);
    if (rebalance_.is_under_way()) return;
    if (some_come) return admit();
    if (epochs_.must_synchronize(*engine_) && epochs_.wants_next()) synchronize();
    phases_.time(Phase::balance, "next epoch", [&] { epochs_.advance(*engine_); });
}

/// The binned state, with nothing under way.
template <class Real, int Dim>
void Simulation<Real, Dim>::synchronize() {
    bin();
    phases_.time(Phase::agree, "synchronize", [&] { engine_->synchronize(); });
}

template <class Real, int Dim>
std::vector<BlockLoad> Simulation<Real, Dim>::block_loads() {
    bin();
    return loads_.gather(engine_->block_counts(loads_.weighs_cells()));
}

/// With particles that were put into the host's share.
template <class Real, int Dim>
void Simulation<Real, Dim>::begin_epoch(const BinnedBlocks& binned) {
    engine_->begin_epoch(epochs_.make(loads_.gather(counts_of(patch(), binned, false))), HostShare{binned});
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
    if (epochs_.must_synchronize(*engine_)) synchronize();
    phases_.time(Phase::balance, "imbalance check", [&] {
        const BlockCounts mine = engine_->block_counts(loads_.weighs_cells());
        loads_.refine(mine, clock_.step, phases_.computing());
        const std::int64_t most = -comm_.max(-std::min(most_, mine.capacity));
        ImbalanceCheckInput input{{}, clock_.round, most, loads_.unit()};
        loads_.take_times(clock_.step, input.times);
        epochs_.forget_next();
        rebalance_.begin(clock_.step, loads_.of(mine), std::move(input));
        epochs_.lifetime().begin_next();
    });
}

/// What is due is taken: blocks move, or all stays. now: it cannot wait.
template <class Real, int Dim>
void Simulation<Real, Dim>::continue_check(bool now) {
    std::optional<EpochTables<Dim>> tables;
    phases_.time(Phase::balance, "plan", [&] {
        const EpochLifetime& epoch = epochs_.lifetime();
        rebalance_.advance(clock_.step, agreement().making != 0, now || epoch.is_used_up() || epoch.next_is_used_up());
        if (rebalance_.state() == Rebalance<Dim>::State::due) tables = rebalance_.take();
    });
    if (!tables) return;
    synchronize();
    phases_.time(Phase::balance, {"repartition", true}, [&] { repartition(std::move(*tables)); });
}

/// Begins the epoch that was planned, and brings blocks to their owners in it: also those that were empty then.
template <class Real, int Dim>
void Simulation<Real, Dim>::repartition(EpochTables<Dim> tables) {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<std::int32_t> of_mine = epochs_.next().owners_of(engine_->block_counts(false).key);
    const BlockMoveCount moved = engine_->begin_epoch(epochs_.counted(std::move(tables)), MovedBlocks{of_mine});
    engine_->refresh_memory(false);
    epochs_.lifetime().begin_made_ahead();
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
