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

/// A block held by several ranks (seeding) is one entry.
inline std::vector<BlockLoad> merged(const std::vector<BlockLoad>& rows) {
    std::vector<BlockLoad> loads;
    loads.reserve(rows.size());
    for (const BlockLoad& row : rows) {
        if (!loads.empty() && loads.back().key == row.key) {
            loads.back().particles += row.particles;
            loads.back().weight += row.weight;
        } else {
            loads.push_back(row);
        }
    }
    return loads;
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
    const bool alone = comm_.size() == 1 && scene_.balance.trigger != Trigger::every;  // nobody to share with
    if (!check_wanted_ && trigger_.is_due(clock_.step + steps_ahead()) && !alone) check_wanted_ = clock_.step;
    if (check_wanted_ && !check_under_way_ && !epoch_ends_soon()) begin_check();
    if (check_under_way_) continue_check();
    if (check_under_way_) return;
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

/// Ranks that plan together do so when they meet.
template <class Real, int Dim>
std::int64_t Simulation<Real, Dim>::steps_ahead() const {
    if (!async_ || partitioner_->is_collective()) return 0;
    return std::min<std::int64_t>(most_steps_ahead, scene_.balance.interval / 2);
}

/// An imbalance check that began now would end with the epoch, and all would wait for its plan: it begins after the new
/// epoch, or an interval later where epochs are short. An imbalance check takes the steps that it begins ahead, and is
/// given as many again.
template <class Real, int Dim>
bool Simulation<Real, Dim>::epoch_ends_soon() const {
    if (steps_ahead() == 0 || scene_.balance.trigger == Trigger::every) return false;
    if (clock_.step >= *check_wanted_ + scene_.balance.interval) return false;
    return epoch_.ends_within(static_cast<double>(2 * steps_ahead()) * agreed_.moved);
}

/// The loads of now are on their way to all ranks, unless all is well without.
template <class Real, int Dim>
void Simulation<Real, Dim>::begin_check() {
    const std::int64_t wanted = *std::exchange(check_wanted_, {});
    ImbalanceCheck found;
    if (is_balanced(found)) return end_check(std::move(found));
    check_due_ = clock_.step + steps_ahead();
    check_latest_ = check_due_;
    if (steps_ahead() > 0 && scene_.balance.trigger != Trigger::every)
        check_latest_ = std::max(check_due_, wanted + scene_.balance.interval - 1);  // one more, and the next is wanted
    if (must_synchronize()) synchronize();
    phases_.time(Phase::balance, [&] {
        const BlockCounts mine = engine_->block_counts(weighs_cells());
        if (weighs_cells()) calibrate(mine);
        if (weight_.is_time()) weight_.set_model({measured_cost_.picoseconds(weight_.model().a), 0, 0});
        check_input_ = {{}, clock_.round, -comm_.max(-engine_->capacity()), weight_.seconds()};
        take_times(check_input_.times);
        keys_.finish();  // what would have been the next epoch
        loads_.start(loads_of(mine));
        epoch_.begin_next();
        check_under_way_ = true;
    });
}

/// Plans, and makes the tables of what was planned, on a thread of its own where epochs are made asynchronously.
template <class Real, int Dim>
void Simulation<Real, Dim>::plan(std::vector<BlockLoad> blocks, std::vector<std::int64_t> counts) {
    const auto owners = [this, blocks = std::move(blocks), counts = std::move(counts)] {
        const std::vector<BlockLoad> loads = merged(in_key_order(blocks, counts));
        planned_ = check_imbalance(loads, check_input_, comm_.size(), *partitioner_, trigger_);
        std::vector<OccupiedBlock> occupied;
        for (std::size_t b = 0; b < planned_.owners.size(); ++b) occupied.push_back({loads[b].key, planned_.owners[b]});
        return occupied;
    };
    next_epoch_.start_repartition(blocks.size(), owners, steps_ahead() > 0);
}

/// What is told of imbalance checks until somebody asks: the last one, unless one before it repartitioned.
template <class Real, int Dim>
void Simulation<Real, Dim>::end_check(ImbalanceCheck found) {
    if (found.repartitioned || !last_check_.repartitioned) last_check_ = std::move(found);
}

/// The imbalance check is taken when it is due and nobody has to wait for a plan, or when the epoch is used up.
template <class Real, int Dim>
void Simulation<Real, Dim>::continue_check() {
    const bool all_have_planned = !loads_.under_way() && !agreed_.making;
    const bool ends = (clock_.step >= check_due_ && all_have_planned) || clock_.step >= check_latest_ ||
                      epoch_.is_used_up() || epoch_.next_is_used_up();
    std::optional<EpochTables<Dim>> tables;
    phases_.time(Phase::balance, [&] {
        if (loads_.under_way())
            if (auto all = ends ? loads_.finish() : loads_.advance())
                plan(std::move(all->rows), std::move(all->counts));
        if (ends) tables = next_epoch_.take();
    });
    if (!ends) return;
    check_under_way_ = false;
    end_check(planned_.found);
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
    trigger_.learn(planned_.found.terms.migration, move_seconds_);
}

}  // namespace moraine
