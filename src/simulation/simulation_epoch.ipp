// Epochs and balancing: who owns which block, and for how long that is known to all.

namespace moraine {

template <class Real, int Dim>
std::vector<BlockLoad> Simulation<Real, Dim>::loads_of(const BlockCounts& mine) const {
    std::vector<BlockLoad> rows;
    rows.reserve(mine.key.size());
    for (std::size_t b = 0; b < mine.key.size(); ++b) {
        const std::int64_t cells = mine.cells.empty() ? 0 : mine.cells[b];
        rows.push_back({mine.key[b], mine.count[b], weight_(mine.count[b], cells), comm_.rank()});
    }
    return rows;
}

/// Occupied blocks of all ranks, in key order.
template <class Real, int Dim>
std::vector<BlockLoad> Simulation<Real, Dim>::gather_loads(const BlockCounts& mine) const {
    std::vector<std::int64_t> counts;
    const std::vector<BlockLoad> all = comm_.all_gather(loads_of(mine), &counts);
    return merged(in_key_order(all, counts));
}

/// Refines the weights by the computing time since the last imbalance check.
template <class Real, int Dim>
void Simulation<Real, Dim>::calibrate(const BlockCounts& mine) {
    const auto steps = static_cast<double>(clock_.step - checked_step_);
    CostSample sample;
    for (std::size_t b = 0; b < mine.key.size(); ++b) {
        sample.particles += static_cast<double>(mine.count[b]);
        sample.cells += static_cast<double>(mine.cells[b]);
    }
    sample.blocks = static_cast<double>(mine.key.size());
    if (steps > 0) sample.seconds = (phases_.computing() - checked_seconds_) / steps;
    checked_seconds_ = phases_.computing();
    checked_step_ = clock_.step;
    calibration_.add(comm_.all_gather(std::vector<CostSample>{sample}));
    weight_.set_model(calibration_.model());
}

template <class Real, int Dim>
std::vector<BlockLoad> Simulation<Real, Dim>::block_loads() {
    bin();
    return gather_loads(engine_->block_counts(weighs_cells()));
}

/// Of this rank's blocks, from the owners of all.
inline std::vector<std::int32_t> owners_of(const BinnedBlocks& mine, const std::vector<BlockLoad>& loads,
                                           const std::vector<std::int32_t>& owners) {
    std::vector<std::int32_t> result;
    for (Key key : mine.key) {
        const auto at = std::lower_bound(loads.begin(), loads.end(), key,
                                         [](const BlockLoad& load, Key k) { return load.key < k; });
        result.push_back(owners[static_cast<std::size_t>(at - loads.begin())]);
    }
    return result;
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
    engine_->adopt(next_epoch(gather_loads(counts_of(patch(), binned, false))), binned);
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
        engine_->renew(std::move(*tables));
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

template <class Real, int Dim>
void Simulation<Real, Dim>::balance() {
    rebalance_.want(clock_.step);
    if (rebalance_.is_to_begin(clock_.step, epoch_, agreed_.moved)) begin_check();
    if (rebalance_.is_under_way()) continue_check();
    if (rebalance_.is_under_way()) return;
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

/// By what the agreements say of the ranks, before anything is binned or sent: no plan is worth making. Costs may say
/// otherwise, but only block by block.
template <class Real, int Dim>
bool Simulation<Real, Dim>::is_balanced(ImbalanceCheck& found) const {
    if (weighs_cells()) return false;
    found.terms.now = weight_.is_time() ? measured_cost_.load(comm_.size())
                                        : LoadSummary{agreed_.count, agreed_.count_sum, comm_.size()};
    found.reason = "balanced";
    if (!trigger_.needs_plan(found.terms.now)) return true;
    take_times(found.terms);
    found.reason = "not worth it";
    return !trigger_.may_pay(found.terms);
}

/// What steps took by the last agreement.
template <class Real, int Dim>
void Simulation<Real, Dim>::take_times(TriggerInput& terms) const {
    terms.step = clock_.step;
    terms.last_repartition = last_repartition_;
    terms.slowest = agreed_.seconds;
    terms.loses = agreed_.seconds - agreed_.seconds_sum / comm_.size();
    terms.lost = time_lost_;
}

/// The loads of now are on their way to all ranks, unless all is well without.
template <class Real, int Dim>
void Simulation<Real, Dim>::begin_check() {
    ImbalanceCheck found;
    if (is_balanced(found)) return rebalance_.skip(std::move(found));
    if (must_synchronize()) synchronize();
    phases_.time(Phase::balance, [&] {
        const BlockCounts mine = engine_->block_counts(weighs_cells());
        if (weighs_cells()) calibrate(mine);
        if (weight_.is_time()) weight_.set_model({measured_cost_.picoseconds(weight_.model().a), 0, 0});
        ImbalanceCheckInput input{{}, clock_.round, -comm_.max(-engine_->capacity()), weight_.seconds()};
        take_times(input.times);
        keys_.finish();  // what would have been the next epoch
        rebalance_.begin(clock_.step, loads_of(mine), std::move(input));
        epoch_.begin_next();
    });
}

/// What is due is taken: blocks move, or all stays.
template <class Real, int Dim>
void Simulation<Real, Dim>::continue_check() {
    std::optional<EpochTables<Dim>> tables;
    phases_.time(Phase::balance, [&] {
        rebalance_.advance(clock_.step, agreed_.making != 0, epoch_.is_used_up() || epoch_.next_is_used_up());
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
    const BlockMoveCount moved = engine_->repartition(std::move(tables), of_mine);
    engine_->refresh_memory(false);
    epoch_.begin_made_ahead();
    counts_.migrated_particles += moved.particles;
    counts_.migrated_blocks += moved.blocks;
    ++counts_.repartitions;
    ++clock_.round;
    last_repartition_ = clock_.step;
    time_lost_ = 0;
    measured_cost_.forget();
    move_seconds_ = comm_.max(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    rebalance_.learn(move_seconds_);
}

}  // namespace moraine
