#pragma once
// One rank's share of the run: its particles, the lists of its blocks, and the tiles and nodes of a step.
//
// Between epochs the share is told as BinnedBlocks: keys, counts and slots in list order; that is the
// state that is repartitioned, stored and restored. Within an epoch the lists are indexed by own block.

#include <algorithm>
#include <new>
#include <span>
#include <vector>

#include "blocks/epoch.hpp"
#include "blocks/tile_storage.hpp"
#include "core/grid/binning.hpp"
#include "core/particles/particles.hpp"

namespace moraine {

/// Blocks with their particles' slots in list order, keys ascending.
struct BinnedBlocks {
    std::vector<Key> key;
    std::vector<std::uint32_t> count;
    std::vector<std::uint32_t> slot;
};

template <class Space, class Real, int Dim>
class Patch {
  public:
    template <class T>
    using Array = typename Space::template Array<T>;

    Patch(const ColumnNeeds& needs, int stencil_width) : particles(needs), width_(stencil_width) {}

    Particles<Space, Real, Dim> particles;

    const EpochTables<Dim>& tables() const { return tables_; }
    int own() const { return static_cast<int>(tables_.own.size()); }
    std::int64_t count() const { return own() == 0 ? 0 : first_[static_cast<std::size_t>(own())]; }
    std::int64_t tiles_in_use() const { return storage_.tiles_in_use(); }
    std::size_t stored_nodes() const { return storage_.stored_nodes(); }
    /// Changes where the memory of tiles was lost.
    std::int64_t tile_memory() const { return storage_.memory(); }

    BlockTable<Dim> table() const { return blocks_.table(tables_); }
    ListView<Dim> list() const { return {first_.data(), cell_first_.data(), slot_.data()}; }
    TileView<Real> grid() { return storage_.view(); }
    std::int32_t* tile_of() { return storage_.tile_of(); }
    std::uint16_t* moves() { return moves_.data(); }
    std::uint32_t* outgoing_count() { return outgoing_count_.data(); }
    std::uint8_t* shuffled() { return shuffled_.data(); }
    BlockOutcome* outcome() { return outcome_.data(); }
    const BlockOutcome& outcome(int block) const { return outcome_[static_cast<std::size_t>(block)]; }

    /// Lists of blocks for the kernels, which skip empty ones.
    std::span<const std::int32_t> boundary() const { return boundary_.span(); }
    std::span<const std::int32_t> interior() const { return interior_.span(); }
    std::span<const std::int32_t> blocks() const { return every_.span().first(tables_.own.size()); }
    std::span<const std::int32_t> node_blocks() const { return every_.span().first(tables_.node_key.size()); }

    /// New particles' slots; the caller fills them. Throws std::bad_alloc beyond 2^32 - 1.
    std::vector<std::uint32_t> take_slots(std::size_t n);
    void give_slots(std::span<const std::uint32_t> slots) { free_.insert(free_.end(), slots.begin(), slots.end()); }

    /// Forgets all particles and makes space for n in the slots 0, 1, ..., which are returned.
    std::vector<std::uint32_t> start_over(std::size_t n);
    /// Begins an epoch: `binned` holds blocks of tables.own only.
    void install(EpochTables<Dim> tables, const BinnedBlocks& binned);
    /// The binned state of this moment. Nothing may be under way.
    BinnedBlocks binned() const;

    /// Binning, first half: lists this step's outgoing particles by own block. Returns their number.
    std::uint32_t collect_outgoing();
    std::span<const OutgoingParticle> outgoing_of(int block) const;
    /// Binning, second half, once the incoming particles from other ranks stand behind the own outgoing particles:
    /// `ghost_outgoing` in ghost order, `ghost_first` with ghosts + 1 entries.
    void make_lists(const std::vector<OutgoingParticle>& ghost_outgoing, const std::vector<std::uint32_t>& ghost_first);

    /// Node blocks that have values in this epoch whoever touches them; needed: by node block. Binned state only.
    void keep_nodes(std::vector<std::uint8_t> needed);

    /// Whether some particle is in a cell of the guard layer. Binned state only.
    bool is_in_guard_layer() const;

    /// Puts the memory into list order if more than `share` of it is out of order or unused.
    void refresh_memory(double share);

    /// Cell within its block of the particle in a slot.
    int cell_of_slot(std::uint32_t slot) {
        const auto& u = particles.view().position[slot];
        int cell = 0;
        for (int a = Dim - 1; a >= 0; --a) cell = 4 * cell + cell_of<Real>(u[a]);
        return cell;
    }

  private:
    void assign_storage() { storage_.assign(table(), list(), tables_.kept_nodes, width_); }
    void count_cells(int block);

    int width_;
    EpochTables<Dim> tables_;
    BlockArrays<Space, Dim> blocks_;

    Array<std::uint32_t> first_, cell_first_, slot_, next_slot_, next_count_, next_first_;
    Array<std::uint16_t> moves_;
    Array<std::uint32_t> outgoing_count_, outgoing_first_;
    Array<OutgoingParticle> outgoing_;
    Array<std::uint8_t> shuffled_;
    Array<BlockOutcome> outcome_;
    std::vector<std::uint32_t> free_;
    std::uint64_t reordered_ = 0;  ///< particles whose list place no longer follows memory

    Array<std::int32_t> boundary_, interior_, every_;
    TileStorage<Space, Real, Dim> storage_;
};

}  // namespace moraine
