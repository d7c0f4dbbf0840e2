// Definitions of comm/patch.hpp.

namespace moraine {

template <class Space, class Real, int Dim>
BlockTable<Dim> Patch<Space, Real, Dim>::table() const {
    BlockTable<Dim> t;
    t.own = own();
    t.ghosts = static_cast<int>(tables_.ghost.size());
    t.position = position_.data();
    t.neighbour = neighbour_.data();
    t.node_block = node_block_.data();
    t.border = border_.data();
    t.node_blocks = static_cast<int>(tables_.node_key.size());
    t.node_position = node_position_.data();
    t.source = source_.data();
    t.node_border = node_border_.data();
    return t;
}

template <class Space, class Real, int Dim>
std::vector<std::uint32_t> Patch<Space, Real, Dim>::take_slots(std::size_t n) {
    std::vector<std::uint32_t> taken;
    taken.reserve(n);
    while (taken.size() < n && !free_.empty()) {
        taken.push_back(free_.back());
        free_.pop_back();
    }
    const std::size_t more = n - taken.size();
    const std::size_t old = particles.size();
    if (more > 0) particles.resize(old + more);
    for (std::size_t k = 0; k < more; ++k) taken.push_back(static_cast<std::uint32_t>(old + k));
    return taken;
}

template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::install(EpochTables<Dim> tables, const FiledBlocks& filed) {
    tables_ = std::move(tables);
    position_.assign(tables_.position);
    neighbour_.assign(tables_.neighbour);
    border_.assign(tables_.border);
    node_block_.assign(tables_.node_block);
    node_position_.assign(tables_.node_position);
    node_border_.assign(tables_.node_border);
    source_.assign(tables_.source);

    const auto n = static_cast<std::size_t>(own());
    std::vector<std::uint32_t> counts(n, 0);
    for (std::size_t f = 0; f < filed.key.size(); ++f)
        counts[static_cast<std::size_t>(tables_.find_own(filed.key[f]))] = filed.count[f];
    first_.resize(n + 1);
    Space::scan(n, counts.data(), first_.data());
    slot_.assign(filed.slot);
    cell_first_.resize(n * (Block<Dim>::cells + 1));
    leavers_.assign(n, 0);
    shuffled_.assign(n, 0);
    outcome_.assign(n, BlockOutcome{});
    moves_.resize(slot_.size());
    Space::launch(own(), [this](int block) { count_cells(block); });
    assign_storage();
}

/// The list is sorted by cell already: only the bounds are missing.
template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::count_cells(int block) {
    std::uint32_t* first = cell_first_.data() + static_cast<std::size_t>(block) * (Block<Dim>::cells + 1);
    std::fill_n(first, Block<Dim>::cells + 1, 0u);
    const auto* position = particles.view().position;
    for (std::uint32_t k = first_[static_cast<std::size_t>(block)]; k < first_[static_cast<std::size_t>(block) + 1]; ++k) {
        int cell = 0;
        for (int a = Dim - 1; a >= 0; --a) cell = 4 * cell + cell_of<Real>(position[slot_[k]][a]);
        ++first[cell + 1];
    }
    for (int c = 0; c < Block<Dim>::cells; ++c) first[c + 1] += first[c];
}

template <class Space, class Real, int Dim>
FiledBlocks Patch<Space, Real, Dim>::filed() const {
    FiledBlocks f;
    for (int b = 0; b < own(); ++b) {
        const auto i = static_cast<std::size_t>(b);
        if (first_[i + 1] == first_[i]) continue;
        f.key.push_back(tables_.own[i]);
        f.count.push_back(first_[i + 1] - first_[i]);
    }
    f.slot.assign(slot_.data(), slot_.data() + count());
    return f;
}

template <class Space, class Real, int Dim>
std::uint32_t Patch<Space, Real, Dim>::collect_leavers() {
    const auto n = static_cast<std::size_t>(own());
    leaver_first_.resize(n + tables_.ghost.size() + 1);
    const std::uint32_t total = Space::scan(n, leavers_.data(), leaver_first_.data());
    leaver_.resize(total);
    Space::launch(own(), CollectLeavers<Dim>{list(), moves_.data(), leaver_first_.data(), leaver_.data()});
    return total;
}

template <class Space, class Real, int Dim>
std::span<const Leaver> Patch<Space, Real, Dim>::leavers_of(int block) const {
    const auto b = static_cast<std::size_t>(block);
    return {leaver_.data() + leaver_first_[b], leaver_.data() + leaver_first_[b + 1]};
}

template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::make_lists(const std::vector<Leaver>& ghost_leaver,
                                         const std::vector<std::uint32_t>& ghost_first) {
    const auto n = static_cast<std::size_t>(own());
    const std::size_t mine = leaver_.size();
    leaver_.resize(mine + ghost_leaver.size());
    std::copy(ghost_leaver.begin(), ghost_leaver.end(), leaver_.data() + mine);
    for (std::size_t g = 0; g < tables_.ghost.size(); ++g)
        leaver_first_[n + g + 1] = static_cast<std::uint32_t>(mine) + ghost_first[g + 1];

    next_count_.resize(n);
    next_first_.resize(n + 1);
    Space::launch(own(), CountNextList<Dim>{table(), list(), leavers_.data(), leaver_first_.data(), leaver_.data(),
                                            shuffled_.data(), next_count_.data()});
    const std::uint32_t total = Space::scan(n, next_count_.data(), next_first_.data());
    next_slot_.resize(total);
    Space::launch(own(), FillNextList<Dim>{table(), list(), moves_.data(), leaver_first_.data(), leaver_.data(),
                                           shuffled_.data(), next_first_.data(), next_slot_.data(), cell_first_.data()});
    reordered_ += leaver_.size();
    slot_.swap(next_slot_);
    first_.swap(next_first_);
    moves_.resize(slot_.size());
    leavers_.assign(n, 0);  // the gather visits occupied blocks only
    shuffled_.assign(n, 0);
    assign_storage();
}

/// Tiles go to occupied blocks, node values to the node blocks that those touch; ghosts come first.
template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::assign_storage() {
    const auto ghosts = static_cast<std::int32_t>(tables_.ghost.size());
    tile_of_.resize(static_cast<std::size_t>(own() + ghosts));
    std::vector<std::uint8_t> touched(tables_.node_key.size(), 0);
    std::vector<std::int32_t> all;
    for (int b = 0; b < own(); ++b) {
        const bool here = first_[static_cast<std::size_t>(b) + 1] > first_[static_cast<std::size_t>(b)];
        tile_of_[static_cast<std::size_t>(b)] = here ? ghosts + static_cast<std::int32_t>(all.size()) : -1;
        if (!here) continue;
        all.push_back(b);
        for (int delta = 0; delta < Block<Dim>::corners; ++delta)
            touched[static_cast<std::size_t>(
                tables_.node_block[static_cast<std::size_t>(b * Block<Dim>::corners + delta)])] = 1;
    }
    for (std::int32_t g = 0; g < ghosts; ++g) tile_of_[static_cast<std::size_t>(own() + g)] = -1;
    occupied_ = static_cast<std::int64_t>(all.size());
    const auto tile_reals = static_cast<std::size_t>(power<Dim>(tile_side(width_)) * node_reals);
    tiles_.resize((all.size() + static_cast<std::size_t>(ghosts)) * tile_reals);

    std::vector<std::int32_t> needed;
    node_of_.resize(touched.size());
    for (std::size_t c = 0; c < touched.size(); ++c) {
        node_of_[c] = touched[c] ? static_cast<std::int32_t>(needed.size()) : -1;
        if (touched[c]) needed.push_back(static_cast<std::int32_t>(c));
    }
    nodes_.resize(needed.size() * static_cast<std::size_t>(Block<Dim>::cells * node_reals));
    needed_.assign(needed);
    all_.assign(all);
    const auto here = [this](std::int32_t b) { return tile_of_[static_cast<std::size_t>(b)] >= 0; };
    std::vector<std::int32_t> part;
    std::copy_if(tables_.boundary.begin(), tables_.boundary.end(), std::back_inserter(part), here);
    boundary_.assign(part);
    part.clear();
    std::copy_if(tables_.interior.begin(), tables_.interior.end(), std::back_inserter(part), here);
    interior_.assign(part);
}

template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::refresh_memory(double share) {
    const auto n = static_cast<std::size_t>(count());
    const double loose = static_cast<double>(reordered_) + static_cast<double>(particles.size() - n);
    if (loose <= share * static_cast<double>(n)) return;
    particles.permute(slot_.data(), n);
    for (std::size_t k = 0; k < n; ++k) slot_[k] = static_cast<std::uint32_t>(k);
    free_.clear();
    reordered_ = 0;
}

template <class Space, class Real, int Dim>
std::size_t Patch<Space, Real, Dim>::bytes() {
    const auto of = [](const auto& array) { return array.capacity() * sizeof(*array.data()); };
    return particles.size() * particles.row_bytes() + of(first_) + of(cell_first_) + of(slot_) + of(next_slot_) +
           of(moves_) + of(leaver_) + of(tiles_) + of(nodes_) + of(outcome_);
}

}  // namespace moraine
