#pragma once
// The tiles of a map's columns (core/data/plan_samples.hpp) that soil lies over, and who owns each.
//
// A rank knows the tiles over its own blocks. The owner of a tile follows from its number alone, so ranks share a map
// however the flow lies and whoever has its blocks. What ranks have of a tile comes together at its owner: whole
// numbers and bits, the same in any order. Why not one rectangle on every rank: a long runout would want the domain
// there.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "comm/comm.hpp"
#include "core/data/plan_samples.hpp"

namespace moraine {

/// Of `ranks`.
int owner_of_tile(std::int64_t tile, int ranks);

class PlanTiles {
  public:
    /// mine: numbers of the tiles over this rank's blocks, each once. Collective.
    PlanTiles(const Comm& comm, std::vector<std::int64_t> mine);

    /// Those over this rank's blocks, in the order of what is added up.
    const std::vector<std::int64_t>& mine() const { return mine_; }
    /// Those that this rank owns, of what lies over the blocks of any; ascending.
    const std::vector<std::int64_t>& owned() const { return owned_; }

    /// From what all ranks have of each value of their tiles, that of the owned ones: add(to, value). Collective.
    template <class T, class Add>
    std::vector<T> add_up(const std::vector<T>& values, std::size_t per_column, const Add& add) const {
        const std::size_t n = per_column * static_cast<std::size_t>(PlanColumns::in_tile);
        std::vector<T> came(n * slot_.size()), all(n * owned_.size(), T{});
        comm_.exchange(values, sent_, came, received_, n);
        for (std::size_t k = 0; k < slot_.size(); ++k)
            for (std::size_t v = 0; v < n; ++v) add(all[n * slot_[k] + v], came[n * k + v]);
        return all;
    }

    /// What the owners have of each column of this rank's tiles. Collective.
    template <class T>
    std::vector<T> fetch(const std::vector<T>& owned) const {
        const auto n = static_cast<std::ptrdiff_t>(PlanColumns::in_tile);
        std::vector<T> asked, mine(mine_.size() * static_cast<std::size_t>(n));
        asked.reserve(slot_.size() * static_cast<std::size_t>(n));
        for (std::size_t slot : slot_) {
            const auto from = owned.begin() + n * static_cast<std::ptrdiff_t>(slot);
            asked.insert(asked.end(), from, from + n);
        }
        comm_.exchange(asked, received_, mine, sent_, static_cast<std::size_t>(n));
        return mine;
    }

  private:
    const Comm& comm_;
    std::vector<std::int64_t> mine_, owned_;
    std::vector<std::int64_t> sent_, received_;  ///< tiles to and from each rank
    std::vector<std::size_t> slot_;              ///< of each that is received, among the owned ones
};

}  // namespace moraine
