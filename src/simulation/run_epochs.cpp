#include "simulation/run_epochs.hpp"

#include <utility>

namespace moraine {

template <class Real, int Dim>
EpochTables<Dim> RunEpochs<Real, Dim>::counted(EpochTables<Dim> tables) {
    counts_.blocks_between_hosts = 0;
    for (const PeerHalo& peer : tables.peers)
        if (hosts_[peer.rank] != hosts_[comm_.rank()])
            counts_.blocks_between_hosts += static_cast<std::int64_t>(peer.send.block.size());
    return tables;
}

template <class Real, int Dim>
EpochTables<Dim> RunEpochs<Real, Dim>::make(const std::vector<BlockLoad>& loads) {
    std::vector<OccupiedBlock> occupied;
    for (const BlockLoad& load : loads) occupied.push_back({load.key, load.owner});
    lifetime_.begin();
    return counted(next_.make(std::move(occupied)));
}

template <class Real, int Dim>
void RunEpochs<Real, Dim>::advance(Engine<Real, Dim>& engine) {
    const bool used_up = lifetime_.is_used_up();
    const bool wanted = wants_next();
    const bool under_way = keys_.under_way() || next_.under_way();
    start_next();
    if (wanted && (!under_way || lifetime_.next_is_stale())) request(engine);
    if (used_up) start_next(), renew(engine);
}

/// Begins to make the next epoch from what the last binning found occupied.
template <class Real, int Dim>
void RunEpochs<Real, Dim>::request(Engine<Real, Dim>& engine) {
    keys_.finish();
    keys_.start(engine.block_counts(false).key);
    lifetime_.begin_next();
}

/// The next epoch is made once all ranks' blocks are known: two steps later, or at once where it is wanted now.
template <class Real, int Dim>
void RunEpochs<Real, Dim>::start_next() {
    if (!keys_.under_way()) return;
    const bool now = !async_ || lifetime_.is_used_up();
    if (auto all = now ? keys_.finish() : keys_.advance())
        next_.start(std::move(all->rows), std::move(all->counts), async_);
}

/// Takes the epoch that was made ahead.
template <class Real, int Dim>
void RunEpochs<Real, Dim>::renew(Engine<Real, Dim>& engine) {
    if (std::optional<EpochTables<Dim>> tables = next_.take()) {
        engine.begin_epoch(counted(std::move(*tables)), KeptBlocks{});
        ++counts_.epochs;
    }
    lifetime_.begin_made_ahead();
    engine.refresh_memory(false);
}

template class RunEpochs<float, 2>;
template class RunEpochs<float, 3>;
template class RunEpochs<double, 2>;
template class RunEpochs<double, 3>;

}  // namespace moraine
