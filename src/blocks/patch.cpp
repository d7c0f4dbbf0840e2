#include "blocks/patch.hpp"

#include <bit>

#include "core/data/host.hpp"

namespace moraine {

template <class Space, class Real, int Dim>
std::vector<std::uint32_t> Patch<Space, Real, Dim>::take_slots(std::size_t n) {
    constexpr std::size_t most = ~std::uint32_t(0);
    if (n > most || particles.size() + n - std::min(n, free_.size()) > most) throw std::bad_alloc();  // of slots
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
std::vector<std::uint32_t> Patch<Space, Real, Dim>::start_over(std::size_t n) {
    free_.clear();
    reordered_ = 0;
    particles.resize(n);
    std::vector<std::uint32_t> slots(n);
    for (std::size_t k = 0; k < n; ++k) slots[k] = static_cast<std::uint32_t>(k);
    return slots;
}

template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::install(EpochTables<Dim> tables, const BinnedBlocks& binned) {
    tables_ = std::move(tables);
    blocks_.assign(tables_);

    const auto n = static_cast<std::size_t>(own());
    std::vector<std::uint32_t> counts(n, 0);
    for (std::size_t f = 0; f < binned.key.size(); ++f)
        counts[static_cast<std::size_t>(tables_.find_own(binned.key[f]))] = binned.count[f];
    first_.resize(n + 1);
    Space::scan(n, counts.data(), first_.data());
    slot_.assign(binned.slot);
    cell_first_.resize(n * (Block<Dim>::cells + 1));
    boundary_.assign(tables_.boundary);
    interior_.assign(tables_.interior);
    every_.resize(std::max(n, tables_.node_key.size()));
    for (std::size_t b = 0; b < every_.size(); ++b) every_[b] = static_cast<std::int32_t>(b);
    outgoing_count_.resize(n);
    shuffled_.resize(n);
    outcome_.resize(n);
    moves_.resize(slot_.size());
    storage_.lose();
    Space::launch(own(), [this](int block) { count_cells(block); });
    assign_storage();
}

/// The list is sorted by cell already: only the bounds are missing.
template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::count_cells(int block) {
    std::uint32_t* first = cell_first_.data() + static_cast<std::size_t>(block) * (Block<Dim>::cells + 1);
    std::fill_n(first, Block<Dim>::cells + 1, 0u);
    for (std::uint32_t k = first_[static_cast<std::size_t>(block)]; k < first_[static_cast<std::size_t>(block) + 1];
         ++k) {
        ++first[cell_of_slot(slot_[k]) + 1];
    }
    for (int c = 0; c < Block<Dim>::cells; ++c) first[c + 1] += first[c];
}

template <class Space, class Real, int Dim>
BinnedBlocks Patch<Space, Real, Dim>::binned() const {
    BinnedBlocks f;
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
std::uint32_t Patch<Space, Real, Dim>::collect_outgoing() {
    const auto n = static_cast<std::size_t>(own());
    outgoing_first_.resize(n + tables_.ghost.size() + 1);
    const std::uint32_t total = Space::scan(n, outgoing_count_.data(), outgoing_first_.data());
    outgoing_.resize(total);
    Space::launch(own(), CollectOutgoing<Dim>{list(), moves_.data(), outgoing_first_.data(), outgoing_.data()});
    return total;
}

template <class Space, class Real, int Dim>
std::span<const OutgoingParticle> Patch<Space, Real, Dim>::outgoing_of(int block) const {
    const auto b = static_cast<std::size_t>(block);
    return {outgoing_.data() + outgoing_first_[b], outgoing_.data() + outgoing_first_[b + 1]};
}

template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::make_lists(const std::vector<OutgoingParticle>& ghost_outgoing,
                                         const std::vector<std::uint32_t>& ghost_first) {
    const auto n = static_cast<std::size_t>(own());
    const std::size_t mine = outgoing_.size();
    outgoing_.resize(mine + ghost_outgoing.size());
    std::copy(ghost_outgoing.begin(), ghost_outgoing.end(), outgoing_.data() + mine);
    for (std::size_t g = 0; g < tables_.ghost.size(); ++g)
        outgoing_first_[n + g + 1] = static_cast<std::uint32_t>(mine) + ghost_first[g + 1];

    next_count_.resize(n);
    next_first_.resize(n + 1);
    Space::launch(own(), CountNextList<Dim>{table(), list(), outgoing_count_.data(), outgoing_first_.data(),
                                            outgoing_.data(), shuffled_.data(), next_count_.data()});
    const std::uint32_t total = Space::scan(n, next_count_.data(), next_first_.data());
    next_slot_.resize(total);
    Space::launch(own(),
                  FillNextList<Dim>{table(), list(), moves_.data(), outgoing_first_.data(), outgoing_.data(),
                                    shuffled_.data(), next_first_.data(), next_slot_.data(), cell_first_.data()});
    reordered_ += outgoing_.size();
    slot_.swap(next_slot_);
    first_.swap(next_first_);
    moves_.resize(slot_.size());
    assign_storage();
}

template <class Space, class Real, int Dim>
bool Patch<Space, Real, Dim>::is_in_guard_layer() const {
    const ListView<Dim> lists = list();
    for (int b = 0; b < own(); ++b) {
        std::uint64_t guard_layer = tables_.guard_layer[static_cast<std::size_t>(b)];
        if (lists.count(b) == 0) continue;
        const std::uint32_t* bounds = lists.cell_first + std::int64_t(b) * (Block<Dim>::cells + 1);
        for (; guard_layer != 0; guard_layer &= guard_layer - 1) {
            const int cell = std::countr_zero(guard_layer);
            if (bounds[cell + 1] > bounds[cell]) return true;
        }
    }
    return false;
}

template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::keep_nodes(std::vector<std::uint8_t> needed) {
    tables_.kept_nodes = std::move(needed);
    assign_storage();
}

template <class Space, class Real, int Dim>
void Patch<Space, Real, Dim>::refresh_memory(double share) {
    const auto n = static_cast<std::size_t>(count());
    const double loose = static_cast<double>(reordered_) + static_cast<double>(particles.size() - n);
    if (loose <= share * static_cast<double>(n)) return;
    storage_.lend([&] { particles.permute(slot_.data(), n); });  // tiles are of a step: a spare column
    for (std::size_t k = 0; k < n; ++k) slot_[k] = static_cast<std::uint32_t>(k);
    free_.clear();
    reordered_ = 0;
}

template class Patch<Host, float, 2>;
template class Patch<Host, float, 3>;
template class Patch<Host, double, 2>;
template class Patch<Host, double, 3>;

}  // namespace moraine
