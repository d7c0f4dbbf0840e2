// Epochs and balancing: who owns which block, and for how long that is known to all.

namespace moraine {

/// Cells of a block that hold particles.
template <class Space, class Real, int Dim>
std::int64_t Simulation<Space, Real, Dim>::occupied_cells(std::span<const std::uint32_t> slots) const {
    std::uint64_t seen = 0;
    for (std::uint32_t s : slots) seen |= std::uint64_t(1) << patch_->cell_of_slot(s);
    return std::popcount(seen);
}

/// Occupied blocks of all ranks, in key order; a block held by several ranks (seeding) is one entry.
template <class Space, class Real, int Dim>
std::vector<BlockLoad> Simulation<Space, Real, Dim>::gather_loads(const FiledBlocks& mine) const {
    std::vector<BlockLoad> rows;
    const bool by_cost = scene_.balance.weight == "cost";
    std::size_t at = 0;
    for (std::size_t b = 0; b < mine.key.size(); at += mine.count[b], ++b) {
        const std::int64_t cells = by_cost ? occupied_cells(std::span(mine.slot).subspan(at, mine.count[b])) : 0;
        rows.push_back({mine.key[b], mine.count[b], weight_(mine.count[b], cells), comm_.rank()});
    }
    std::vector<BlockLoad> all = comm_.all_gather(rows);
    std::sort(all.begin(), all.end(), [](const BlockLoad& a, const BlockLoad& b) { return a.key < b.key; });
    std::vector<BlockLoad> loads;
    for (const BlockLoad& row : all) {
        if (!loads.empty() && loads.back().key == row.key) {
            loads.back().particles += row.particles;
            loads.back().weight += row.weight;
        } else {
            loads.push_back(row);
        }
    }
    return loads;
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

/// A new topology from what is occupied now; owners are the ranks that hold the blocks.
template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::begin_epoch(const FiledBlocks& filed) {
    std::vector<OccupiedBlock> occupied;
    for (const BlockLoad& load : gather_loads(filed)) occupied.push_back({load.key, load.owner});
    const Topology<Dim> topology = make_topology<Dim>(domain_, occupied, [this](const BlockPosition<Dim>& at) {
        Position position{};
        std::copy(at.begin(), at.end(), position.begin());
        return partitioner_->owner_at(position);
    });
    end_epoch();
    patch_->install(make_epoch<Dim>(topology, domain_, method_.stencil, comm_.rank()), filed);
    patch_->refresh_memory(0.1);
    halo_ = std::make_unique<Halo<Real, Dim>>(patch_->tables(), halo_wire_, method_.stencil.width);
    migration_ = std::make_unique<Migration<Space, Real, Dim>>(*patch_, migration_wire_);
    wandered_ = 0;
}

template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::end_epoch() {
    if (!halo_) return;
    counts_ = counts_so_far();
    halo_.reset();
    migration_.reset();
}

template <class Space, class Real, int Dim>
RunCounts Simulation<Space, Real, Dim>::counts_so_far() const {
    RunCounts counts = counts_;
    if (halo_) counts.halo_bytes += halo_->bytes();
    if (migration_) counts.crossed_particles += migration_->crossed();
    return counts;
}

/// A block's particles may have moved `wandered_` cells by the step before and less than one more in
/// the last: below 4 in all they are still in blocks of the topology.
template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::balance() {
    const bool look = trigger_.is_due(clock_.step);
    const bool used_up = wandered_ > 2;
    look_.repartitioned = false;
    if (!look && !used_up) return;
    file();
    phases_.time(Phase::balance, [&] {
        const FiledBlocks filed = patch_->filed();
        if (look) {
            std::vector<BlockLoad> loads = gather_loads(filed);
            const std::vector<std::int32_t> owners = plan(loads);
            if (look_.repartitioned) return repartition(filed, loads, owners);
        }
        if (used_up) begin_epoch(filed);
    });
}

/// Looks at the balance; if it is worth it, the owners to be.
template <class Space, class Real, int Dim>
std::vector<std::int32_t> Simulation<Space, Real, Dim>::plan(std::vector<BlockLoad>& loads) {
    const int ranks = comm_.size();
    TriggerInput& terms = look_.terms;
    terms = TriggerInput{};
    terms.step = clock_.step;
    terms.last_repartition = last_repartition_;
    terms.now = summary_of(loads_of_ranks(loads, present_owners(loads), ranks));
    look_.reason = "balanced";
    if (!trigger_.needs_plan(terms.now)) return {};
    const std::vector<std::int32_t> owners = partitioner_->owners(loads, clock_.round);
    terms.plan = summary_of(loads_of_ranks(loads, owners, ranks));
    terms.loses = agreed_.seconds - agreed_.seconds_sum / ranks;
    terms.lost = time_lost_;
    terms.migration = move_seconds_;
    const Decision decision = trigger_.decide(terms);
    look_.repartitioned = decision.repartition;
    look_.reason = decision.reason;
    return owners;
}

template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::repartition(const FiledBlocks& filed, const std::vector<BlockLoad>& loads,
                                               const std::vector<std::int32_t>& owners) {
    const auto start = std::chrono::steady_clock::now();
    BlockMoveCount moved;
    const FiledBlocks next = move_blocks(comm_, *patch_, filed, owners_of(filed, loads, owners), moved);
    begin_epoch(next);
    counts_.migrated_particles += moved.particles;
    counts_.migrated_blocks += moved.blocks;
    ++counts_.repartitions;
    ++clock_.round;
    last_repartition_ = clock_.step;
    time_lost_ = 0;
    move_seconds_ = comm_.max(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace moraine
