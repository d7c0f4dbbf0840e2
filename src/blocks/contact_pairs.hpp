#pragma once
// Which blocks of an epoch are near which structures: the tiles of gaps (core/structures/particle_gaps.hpp), and their
// numbers.
//
// Nearness follows from the place of the block and that of the structure alone, which all ranks know: the two sides of
// a message number the same tiles without a word. Blocks and structures that rest keep their pairs for the epoch;
// where a structure moves they are made anew in each step. Empty blocks have pairs too, so nothing depends on who is
// where. With them goes the plane over the ground under each block (core/structures/ground_bound.hpp), and blocks that
// are wholly out of its reach have no pair.

#include <vector>

#include "blocks/epoch.hpp"
#include "core/structures/particle_gaps.hpp"

namespace moraine {

template <int Dim>
class ContactPairs {
  public:
    /// The next make() begins anew. Not collective.
    void forget() { made_ = false; }
    /// Pairs of own blocks and tiles of ghosts. moved: since the last time. Returns whether they are new. Not
    /// collective.
    bool make(const EpochTables<Dim>& tables, const ContactField<Dim>& field, bool moved);

    const std::vector<ContactPair>& boundary() const { return boundary_; }
    const std::vector<ContactPair>& interior() const { return interior_; }
    const std::vector<std::int32_t>& tile_of() const { return tile_of_; }  ///< (own + ghosts) x structures
    std::size_t tiles() const { return tiles_; }
    /// By block, of own ones first; null: there is no ground.
    const GroundBound<Dim>* bounds() const { return bounds_.empty() ? nullptr : bounds_.data(); }
    int structures() const { return structures_; }

    /// Tiles of a block, of own ones first, then of ghosts.
    int of_block(std::size_t block) const {
        int n = 0;
        const auto k = static_cast<std::size_t>(structures_);
        for (std::size_t s = 0; s < k; ++s) n += tile_of_[block * k + s] >= 0;
        return n;
    }

  private:
    void list(const std::vector<std::int32_t>& blocks, std::vector<ContactPair>& pairs) const;

    bool made_ = false;
    int structures_ = 0;
    std::size_t tiles_ = 0;
    std::vector<std::int32_t> tile_of_;
    std::vector<GroundBound<Dim>> bounds_;
    std::vector<ContactPair> boundary_, interior_;
};

}  // namespace moraine
