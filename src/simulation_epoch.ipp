// Epochs and balancing: who owns which block, and for how long that is known to all.

namespace moraine {

/// Occupied blocks of all ranks, in key order; a block held by several ranks (seeding) is one entry.
template <class Real, int Dim>
std::vector<BlockLoad> Simulation<Real, Dim>::gather_loads(const BlockCounts& mine) const {
    std::vector<BlockLoad> rows;
    for (std::size_t b = 0; b < mine.key.size(); ++b) {
        const std::int64_t cells = mine.cells.empty() ? 0 : mine.cells[b];
        rows.push_back({mine.key[b], mine.count[b], weight_(mine.count[b], cells), comm_.rank()});
    }
    std::vector<std::int64_t> counts;
    const std::vector<BlockLoad> all = comm_.all_gather(rows, &counts);
    std::vector<BlockLoad> loads;
    loads.reserve(all.size());
    for (const BlockLoad& row : in_key_order(all, counts)) {
        if (!loads.empty() && loads.back().key == row.key) {
            loads.back().particles += row.particles;
            loads.back().weight += row.weight;
        } else {
            loads.push_back(row);
        }
    }
    return loads;
}

/// Refines the weights by the computing time since the last look.
template <class Real, int Dim>
void Simulation<Real, Dim>::calibrate(const BlockCounts& mine) {
    const auto steps = static_cast<double>(clock_.step - looked_step_);
    CostSample sample;
    for (std::size_t b = 0; b < mine.key.size(); ++b) {
        sample.particles += static_cast<double>(mine.count[b]);
        sample.cells += static_cast<double>(mine.cells[b]);
    }
    sample.blocks = static_cast<double>(mine.key.size());
    if (steps > 0) sample.seconds = (phases_.computing() - looked_) / steps;
    looked_ = phases_.computing();
    looked_step_ = clock_.step;
    calibration_.add(comm_.all_gather(std::vector<CostSample>{sample}));
    weight_.set_model(calibration_.model());
}

template <class Real, int Dim>
std::vector<BlockLoad> Simulation<Real, Dim>::block_loads() {
    file();
    return gather_loads(engine_->block_counts(weighs_cells()));
}

/// Of this rank's blocks, from the owners of all.
inline std::vector<std::int32_t> owners_of(const FiledBlocks& mine, const std::vector<BlockLoad>& loads,
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
    wandered_ = 0;
    unfiled_ = true;
    return next_epoch_.make(std::move(occupied));
}

/// With particles that were put into the host's share.
template <class Real, int Dim>
void Simulation<Real, Dim>::begin_epoch(const FiledBlocks& filed) {
    engine_->adopt(next_epoch(gather_loads(counts_of(patch(), filed, false))), filed);
    engine_->refresh_memory(false);
}

/// Begins to make the next epoch from what is occupied now.
template <class Real, int Dim>
void Simulation<Real, Dim>::foresee_epoch() {
    keys_.finish();
    keys_.start(engine_->block_counts(false).key);
    foreseen_ = 0;
}

/// The next epoch is made once all ranks' blocks are known: two steps later, or at once where it is wanted now.
template <class Real, int Dim>
void Simulation<Real, Dim>::look_ahead() {
    if (!keys_.under_way()) return;
    const bool now = !beside_ || wandered_ > epoch_reach;
    if (auto all = now ? keys_.finish() : keys_.advance())
        next_epoch_.start(std::move(all->rows), std::move(all->counts), beside_);
}

/// Takes the epoch that was foreseen.
template <class Real, int Dim>
void Simulation<Real, Dim>::renew_epoch() {
    if (std::optional<EpochTables<Dim>> tables = next_epoch_.take()) {
        engine_->renew(std::move(*tables));
        ++counts_.epochs;
    }
    wandered_ = std::max(0.0, foreseen_ - 1);  // where the rim begins
    unfiled_ = true;
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
    look_.repartitioned = false;
    const bool stale = foreseen_ >= epoch_stale;
    const bool look = trigger_.is_due(clock_.step) && !alone && !moves_at_ && !is_balanced();
    const bool used_up = wandered_ > epoch_reach;
    const bool move = moves_at_ && (clock_.step >= *moves_at_ || used_up || stale);
    const bool wanted = used_up || (beside_ && at_rim_);
    const bool foresee = wanted && !moves_at_ && !((keys_.under_way() || next_epoch_.under_way()) && !stale);
    if (keys_.under_way()) phases_.time(Phase::balance, [&] { look_ahead(); });
    if (!look && !used_up && !foresee && !move) return;
    if (move || !(beside_ && engine_->leaves_host_free())) {
        file();
        phases_.time(Phase::agree, [&] { engine_->settle(); });
    }
    phases_.time(Phase::balance, [&] {
        if (move) return repartition();
        if (look && repartition_if_worth_it()) return;
        if (foresee) foresee_epoch();
        if (used_up) look_ahead(), renew_epoch();
    });
}

/// True: this epoch ends now.
template <class Real, int Dim>
bool Simulation<Real, Dim>::repartition_if_worth_it() {
    const BlockCounts mine = engine_->block_counts(weighs_cells());
    if (weighs_cells()) calibrate(mine);
    if (weight_.is_time()) weight_.set_model({pace_.picoseconds(weight_.model().a), 0, 0});
    std::vector<BlockLoad> loads = gather_loads(mine);
    const std::vector<std::int32_t> owners = plan(loads);
    if (!look_.repartitioned) return false;
    begin_repartition(std::move(loads), owners);
    if (clock_.step >= *moves_at_ || wandered_ > epoch_reach) repartition();
    return true;
}

/// By what the agreements say of the ranks, before anything is filed or sent: no plan is worth making. Costs may say
/// otherwise, but only block by block.
template <class Real, int Dim>
bool Simulation<Real, Dim>::is_balanced() {
    if (weighs_cells()) return false;
    look_.terms = TriggerInput{};
    look_.terms.now =
        weight_.is_time() ? pace_.load(comm_.size()) : LoadSummary{agreed_.count, agreed_.count_sum, comm_.size()};
    look_.reason = "balanced";
    if (!trigger_.needs_plan(look_.terms.now)) return true;
    take_times(look_.terms);
    look_.reason = "not worth it";
    return !trigger_.may_pay(look_.terms);
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

/// Looks at the balance; if it is worth it, the owners to be.
template <class Real, int Dim>
std::vector<std::int32_t> Simulation<Real, Dim>::plan(std::vector<BlockLoad>& loads) {
    const int ranks = comm_.size();
    TriggerInput& terms = look_.terms;
    terms = TriggerInput{};
    terms.now = summary_of(loads_of_ranks(loads, present_owners(loads), ranks));
    look_.reason = "balanced";
    if (!trigger_.needs_plan(terms.now)) return {};
    take_times(terms);
    std::vector<Option> options = options_that_fit(loads);
    if (options.empty()) {
        look_.reason = "memory";
        return {};
    }
    const Plan plan = best_plan(std::move(options), loads, ranks, trigger_.costs(terms, weight_.seconds()));
    terms.take(plan);
    const Decision decision = trigger_.decide(terms);
    look_.repartitioned = decision.repartition;
    look_.reason = decision.reason;
    return plan.owners;
}

/// By weight; where a rank cannot hold its part of that, by particles; none where it cannot hold that either.
template <class Real, int Dim>
std::vector<Option> Simulation<Real, Dim>::options_that_fit(const std::vector<BlockLoad>& loads) {
    const auto most = static_cast<std::int64_t>(comm_.min(static_cast<double>(engine_->capacity())));
    std::vector<Option> options = that_fit(partitioner_->options(loads, clock_.round), loads, comm_.size(), most);
    if (!options.empty() || !(weight_.is_cost() || weight_.is_time())) return options;
    std::vector<BlockLoad> by_particles = loads;
    for (BlockLoad& load : by_particles) load.weight = load.particles;
    return that_fit(partitioner_->options(by_particles, clock_.round), loads, comm_.size(), most);
}

/// Tables for the owners to be are made from now on; where that is beside the steps, blocks move some steps later.
template <class Real, int Dim>
void Simulation<Real, Dim>::begin_repartition(std::vector<BlockLoad> loads, const std::vector<std::int32_t>& owners) {
    std::vector<OccupiedBlock> occupied;
    for (std::size_t b = 0; b < loads.size(); ++b) occupied.push_back({loads[b].key, owners[b]});
    keys_.finish();  // what would have been
    next_epoch_.start_repartition(std::move(occupied), beside_);
    foreseen_ = 0;
    reckoned_ = look_.terms.migration;
    const std::int64_t steps = std::min<std::int64_t>(most_steps_to_move, scene_.balance.interval / 2);
    moves_at_ = clock_.step + (beside_ ? steps : 0);
}

/// Takes the epoch that was begun, and brings blocks to their owners in it: also those that were empty then.
template <class Real, int Dim>
void Simulation<Real, Dim>::repartition() {
    const auto start = std::chrono::steady_clock::now();
    EpochTables<Dim> tables = std::move(*next_epoch_.take());
    const std::vector<std::int32_t> of_mine = next_epoch_.owners_of(engine_->block_counts(false).key);
    const BlockMoveCount moved = engine_->repartition(std::move(tables), of_mine);
    engine_->refresh_memory(false);
    moves_at_.reset();
    wandered_ = std::max(0.0, foreseen_ - 1);  // where the rim begins
    unfiled_ = true;
    counts_.migrated_particles += moved.particles;
    counts_.migrated_blocks += moved.blocks;
    ++counts_.repartitions;
    ++clock_.round;
    last_repartition_ = clock_.step;
    time_lost_ = 0;
    pace_.forget();
    move_seconds_ = comm_.max(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    trigger_.learn(reckoned_, move_seconds_);
}

}  // namespace moraine
