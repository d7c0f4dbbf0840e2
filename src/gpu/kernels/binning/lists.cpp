#include "gpu/kernels/binning/lists.hpp"

#include <algorithm>
#include <numeric>

#include "gpu/memory/refresh.hpp"

namespace moraine::gpu {

template <int Dim>
void Lists<Dim>::reserve(const EpochTables<Dim>& tables, cudaStream_t stream) {
    own_ = tables.own.size();
    const std::size_t ghosts = tables.ghost.size();
    tile_of_.resize(own_ + ghosts, stream);
    boundary_.resize(own_, stream);
    interior_.resize(own_, stream);
    occupied_.resize(5);
    cell_first_.resize(own_ * bounds, stream);
    next_first_.resize(own_ + 1, stream);
    outgoing_count_.resize(own_ + ghosts, stream);
    outgoing_bound_.resize((own_ + ghosts) * outgoing_bounds<Dim>, stream);
    // read, and multiplied by nothing, where no particle leaves
    check(cudaMemsetAsync(outgoing_bound_.data(), 0, outgoing_bound_.size() * sizeof(std::uint32_t), stream),
          "Clearing lists");
    ghost_start_.resize(ghosts, stream);
    tally_.resize(static_cast<std::size_t>(binning_chunks(static_cast<int>(own_))), stream);
}

template <int Dim>
void Lists<Dim>::reserve(std::size_t most, cudaStream_t stream) {
    next_slot_.resize(most);
    moves_.resize(most);
    changed_.resize(most / 32 + own_ + 1, stream);
    outgoing_slot_.resize(most);
    outgoing_cell_.resize(most);
}

template <int Dim>
void Lists<Dim>::grow(std::size_t most) {
    slot_.resize(most);
    reserve(most, nullptr);
    count_up(static_cast<std::uint32_t>(most), slot_.data(), nullptr);
    check(cudaDeviceSynchronize(), "Growing the storage of particles");
}

template <int Dim>
void Lists<Dim>::install(const EpochTables<Dim>& tables, const BlockTable<Dim>& table, const BinnedBlocks& binned,
                         std::size_t most) {
    reserve(tables, nullptr);
    first_.assign(first_of(tables, binned), nullptr);
    grow(most);
    number_blocks(binning(table), nullptr);
    check(cudaDeviceSynchronize(), "Taking lists in");
}

template <int Dim>
void Lists<Dim>::rearrange(const EpochTables<Dim>& tables, const BlockTable<Dim>& table, const BinnedBlocks& binned,
                           const std::vector<ListRange>& blocks, cudaStream_t stream) {
    reserve(tables, stream);
    reserve(slot_.size(), stream);
    first_.assign(first_of(tables, binned), stream);
    list_ranges(blocks, slot_.data(), copies_, next_slot_.data(), stream);
    slot_.swap(next_slot_);
    number_blocks(binning(table), stream);
}

template <int Dim>
std::vector<std::uint32_t> Lists<Dim>::first_of(const EpochTables<Dim>& tables, const BinnedBlocks& binned) const {
    std::vector<std::uint32_t> first(tables.own.size() + 1, 0);
    for (std::size_t f = 0, b = 0; f < binned.key.size(); ++f) {  // both ascend
        while (tables.own[b] < binned.key[f]) ++b;
        first[b + 1] = binned.count[f];
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    return first;
}

/// Blocks keep their order, so the slots stay where they are; only bounds are numbered anew.
template <int Dim>
void Lists<Dim>::renew(const EpochTables<Dim>& tables, const BlockTable<Dim>& table, cudaStream_t stream) {
    old_cell_first_.swap(cell_first_);
    reserve(tables, stream);
    reserve(slot_.size(), stream);
    const auto own = static_cast<std::uint32_t>(own_);
    renumber(own + 1, 1, tables_.from.data(), first_.data(), next_first_.data(), stream);
    first_.swap(next_first_);
    next_first_.resize(own_ + 1, stream);
    renumber(own, bounds, tables_.same.data(), old_cell_first_.data(), cell_first_.data(), stream);
    number_blocks(binning(table), stream);
}

template <int Dim>
void Lists<Dim>::limit_tiles(std::uint32_t tiles, const BlockTable<Dim>& table, cudaStream_t stream) {
    tiles_ = tiles;
    number_blocks(binning(table), stream);
}

template <int Dim>
Binning<Dim> Lists<Dim>::binning(const BlockTable<Dim>& table) const {
    return {table,
            view(),
            moves_.data(),
            changed_.data(),
            tables_.is_boundary.data(),
            tables_.guard_layer.data(),
            table.ghosts,
            {outgoing_slot_.data(), outgoing_cell_.data(), outgoing_count_.data(), outgoing_bound_.data(),
             ghost_start_.data()},
            {tile_of_.data(), boundary_.data(), interior_.data(), occupied_.data(), occupied_.data() + 2, tiles_,
             occupied_.data() + 4},
            cell_first_.data(),
            next_first_.data(),
            next_slot_.data(),
            tally_.data()};
}

template <int Dim>
void Lists<Dim>::make(const BlockTable<Dim>& table, cudaStream_t stream) {
    make_lists(binning(table), stream);
    turn();
}

template class Lists<2>;
template class Lists<3>;

}  // namespace moraine::gpu
