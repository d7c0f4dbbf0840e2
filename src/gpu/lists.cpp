#include "gpu/lists.hpp"

#include <numeric>

namespace moraine::gpu {

/// What follows from the number of particles in each own block.
template <int Dim>
void Lists<Dim>::place(const EpochTables<Dim>& tables, const std::vector<std::uint32_t>& counts,
                       std::size_t particles) {
    own_ = tables.own.size();
    std::vector<std::uint8_t> is_boundary(own_, 0);
    for (std::int32_t b : tables.boundary) is_boundary[static_cast<std::size_t>(b)] = 1;
    std::vector<std::uint32_t> first(own_ + 1, 0);
    std::vector<std::int32_t> tile_of(own_, -1), boundary, interior;
    auto tile = static_cast<std::int32_t>(tables.ghost.size());
    for (std::size_t b = 0; b < own_; ++b) {
        first[b + 1] = first[b] + counts[b];
        if (counts[b] == 0) continue;
        tile_of[b] = tile++;
        (is_boundary[b] ? boundary : interior).push_back(static_cast<std::int32_t>(b));
    }
    const auto n_boundary = static_cast<std::uint32_t>(boundary.size());
    const auto n_interior = static_cast<std::uint32_t>(interior.size());
    boundary.resize(own_);
    interior.resize(own_);
    first_.assign(first);
    tile_of_.assign(tile_of);
    boundary_.assign(boundary);
    interior_.assign(interior);
    occupied_.assign({n_boundary, n_interior, n_boundary, n_interior});
    is_boundary_.assign(is_boundary);

    next_first_.resize(own_ + 1);
    next_slot_.resize(particles);
    moves_.resize(particles);
    changed_.resize(particles / 32 + own_ + 1);
    leaver_slot_.resize(particles);
    leaver_cell_.resize(particles);
    leaver_bound_.resize((own_ + tables.ghost.size()) * leaver_bounds<Dim>);
    ghost_start_.resize(tables.ghost.size());
    tally_.resize(static_cast<std::size_t>(filing_chunks(static_cast<int>(own_))));
}

template <int Dim>
void Lists<Dim>::install(const EpochTables<Dim>& tables, const FiledBlocks& filed,
                         const std::vector<std::uint32_t>& cell_first) {
    std::vector<std::uint32_t> counts(tables.own.size(), 0);
    for (std::size_t f = 0; f < filed.key.size(); ++f)
        counts[static_cast<std::size_t>(tables.find_own(filed.key[f]))] = filed.count[f];
    place(tables, counts, filed.slot.size());
    std::vector<std::uint32_t> slots(filed.slot.size());
    std::iota(slots.begin(), slots.end(), 0u);
    slot_.assign(slots);
    cell_first_.assign(cell_first);
}

/// Blocks keep their order, so the slots stay where they are; only bounds are numbered anew.
template <int Dim>
void Lists<Dim>::renew(const EpochTables<Dim>& tables, const std::vector<Key>& old_keys) {
    const std::vector<std::uint32_t> old_first = first_.host();
    const std::vector<std::uint32_t> old_bounds = cell_first_.host();
    std::vector<std::uint32_t> new_counts(tables.own.size(), 0), new_bounds(tables.own.size() * bounds, 0);
    for (std::size_t b = 0; b < old_keys.size(); ++b) {
        if (old_first[b + 1] == old_first[b]) continue;
        const auto i = static_cast<std::size_t>(tables.find_own(old_keys[b]));
        new_counts[i] = old_first[b + 1] - old_first[b];
        std::copy_n(old_bounds.data() + b * bounds, bounds, new_bounds.data() + i * bounds);
    }
    place(tables, new_counts, slot_.size());
    cell_first_.assign(new_bounds);
}

template <int Dim>
void Lists<Dim>::limit_tiles(std::uint32_t tiles) {
    tiles_ = tiles;
    std::vector<std::uint32_t> counts = occupied_.host();
    const bool fit = counts[0] + counts[1] <= tiles;
    counts[2] = fit ? counts[0] : 0;
    counts[3] = fit ? counts[1] : 0;
    occupied_.assign(counts);
}

template <int Dim>
void Lists<Dim>::file(const BlockTable<Dim>& table, cudaStream_t stream) {
    const Filing<Dim> filing{table,
                             view(),
                             moves_.data(),
                             changed_.data(),
                             is_boundary_.data(),
                             table.ghosts,
                             tiles_,
                             {leaver_slot_.data(), leaver_cell_.data(), leaver_bound_.data(), ghost_start_.data()},
                             {next_first_.data(), next_slot_.data(), cell_first_.data(), tile_of_.data(),
                              boundary_.data(), interior_.data(), occupied_.data()},
                             tally_.data()};
    collect_leavers(filing, stream);
    make_lists(filing, stream);
    first_.swap(next_first_);
    slot_.swap(next_slot_);
}

template class Lists<2>;
template class Lists<3>;

}  // namespace moraine::gpu
