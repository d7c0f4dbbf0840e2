#pragma once
// The lists of a rank's blocks on the device, and all that a binning needs to make the next ones.
//
// Memory is taken when an epoch begins, by the number of own blocks and by how many particles there may be at once;
// when more may come, the engine makes space between two steps.

#include <cuda_runtime.h>

#include "blocks/epoch.hpp"
#include "blocks/patch.hpp"
#include "gpu/exchange/block_moves.hpp"
#include "gpu/kernels/binning/binning.hpp"
#include "gpu/kernels/binning/list_tables.hpp"
#include "gpu/kernels/view.hpp"
#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

template <int Dim>
class Lists {
  public:
    static constexpr std::size_t bounds = Block<Dim>::cells + 1;

    /// What an epoch brings; install() or renew() follows.
    void swap(ListTables& tables) { tables_.swap(tables); }
    /// The state of `binned`, whose slots are 0, 1, 2, ... on the device; `table`: the tables' copy there; capacity for
    /// `most` particles. The cells' bounds are left to whoever knows the places. Synchronous.
    void install(const EpochTables<Dim>& tables, const BlockTable<Dim>& table, const BinnedBlocks& binned,
                 std::size_t most);
    /// The same particles under other tables. Asynchronous.
    void renew(const EpochTables<Dim>& tables, const BlockTable<Dim>& table, cudaStream_t stream);
    /// The state of `binned`, whose particles are those of `blocks`; capacity as before. The cells' bounds are left to
    /// whoever knows the places. Asynchronous.
    void rearrange(const EpochTables<Dim>& tables, const BlockTable<Dim>& table, const BinnedBlocks& binned,
                   const std::vector<ListRange>& blocks, cudaStream_t stream);
    /// Capacity for `most` particles. Slots become 0, 1, 2, ...; moves and outgoing particles are lost. Synchronous.
    void grow(std::size_t most);
    /// How many tiles there are: while more blocks are occupied, boundary() and interior() are empty. Asynchronous.
    void limit_tiles(std::uint32_t tiles, const BlockTable<Dim>& table, cudaStream_t stream);

    ListView<Dim> view() const { return {first_.data(), cell_first_.data(), slot_.data()}; }
    Chosen boundary() const { return {boundary_.data(), occupied_.data() + 2}; }
    Chosen interior() const { return {interior_.data(), occupied_.data() + 3}; }
    std::int32_t* tile_of() const { return tile_of_.data(); }  ///< own blocks, then ghosts
    std::uint32_t* cell_bounds() const { return cell_first_.data(); }
    std::size_t capacity() const { return slot_.size(); }
    const std::uint32_t* particles() const { return first_.data() + own_; }
    const std::uint32_t* occupied() const { return occupied_.data(); }  ///< boundary, interior: however many tiles
    const std::uint32_t* in_guard_layer() const { return occupied_.data() + 4; }    ///< Binning::in_guard_layer
    const std::uint8_t* is_boundary() const { return tables_.is_boundary.data(); }  ///< own: 1 where some peer needs it
    std::uint16_t* moves() const { return moves_.data(); }
    std::uint32_t* changed() const { return changed_.data(); }
    std::uint32_t* slots() const { return slot_.data(); }
    const std::uint32_t* former_first() const { return next_first_.data(); }  ///< once made: view().first of before

    /// Occupied blocks that some peer needs.
    std::uint32_t occupied_boundary() const { return occupied_.host().front(); }
    std::vector<std::uint32_t> first() const { return first_.host(); }
    std::vector<std::uint32_t> first(cudaStream_t stream) const { return first_.host(stream); }
    std::vector<std::uint32_t> cell_first(cudaStream_t stream) const { return cell_first_.host(stream); }

    Binning<Dim> binning(const BlockTable<Dim>& table) const;
    /// The next lists, from moves() and changed(): first the outgoing particles, then, once those of ghosts stand
    /// behind the own ones, the lists. Asynchronous.
    void collect(const BlockTable<Dim>& table, Part part, int blocks, cudaStream_t stream) {
        collect_outgoing(binning(table), part, blocks, stream);
    }
    void make(const BlockTable<Dim>& table, cudaStream_t stream);
    /// The lists are those that make() would have left: others made them.
    void turn() { first_.swap(next_first_), slot_.swap(next_slot_); }

  private:
    void reserve(const EpochTables<Dim>& tables, cudaStream_t stream);
    void reserve(std::size_t most, cudaStream_t stream);
    std::vector<std::uint32_t> first_of(const EpochTables<Dim>& tables, const BinnedBlocks& binned) const;

    std::size_t own_ = 0;
    std::uint32_t tiles_ = ~0u;
    ListTables tables_;
    // by particles
    Array<std::uint32_t> slot_, next_slot_, outgoing_slot_;
    Array<std::uint8_t> outgoing_cell_;
    Array<std::uint16_t> moves_;
    // by blocks, in every epoch others
    PoolArray<std::uint32_t> first_, next_first_, cell_first_, old_cell_first_, changed_;
    PoolArray<std::int32_t> tile_of_, boundary_, interior_;
    PoolArray<std::uint32_t> outgoing_count_, outgoing_bound_, ghost_start_;
    PoolArray<Tally> tally_;
    Array<std::uint32_t> occupied_;
    Array<ListCopy> copies_;
};

}  // namespace moraine::gpu
