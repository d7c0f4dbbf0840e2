#pragma once
// Index of a block by its key, through families: the 2^d blocks of one parent, key >> d.
//
// Sorted keys keep a family together, so its first index and a bit per child are enough: the index of a child is first
// + the number of children below it. A flat open-addressing table finds the family. One table look-up serves 2^d
// blocks, and the 3^d around a family serve all neighbours of all its blocks (surroundings.hpp); a table of keys would
// be asked 3^d times per block: 1.5 million times in an epoch of 33 000 blocks, while the devices wait.

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "core/data/block.hpp"
#include "core/data/morton.hpp"

namespace moraine {

struct Family {
    Key parent;          ///< key >> d of its blocks
    std::int32_t first;  ///< index of its first block
    std::uint32_t mask;  ///< bit c: there is the block (parent << d) + c

    bool has(unsigned child) const { return mask >> child & 1u; }
    /// Index of a block, if it is there.
    std::int32_t index_of(unsigned child) const { return first + std::popcount(mask & ((1u << child) - 1)); }
};

/// Places of families in a list, by their parents.
class FamilyTable {
  public:
    FamilyTable() = default;
    explicit FamilyTable(std::size_t families) : mask_(std::bit_ceil(2 * families + 2) - 1), place_(mask_ + 1, -1) {}

    /// Place of a parent in the list that was inserted, or -1.
    std::int32_t find(std::span<const Family> list, Key parent) const {
        std::size_t at = start(parent);
        while (place_[at] >= 0 && list[static_cast<std::size_t>(place_[at])].parent != parent) at = (at + 1) & mask_;
        return place_[at];
    }

    /// Inserts list[place], unless one of that parent is there; the place of the one that is. Threads may insert
    /// together.
    std::int32_t insert(std::span<const Family> list, std::int32_t place);

  private:
    /// Fibonacci hashing: neighbouring keys, which differ in their low bits, are spread.
    std::size_t start(Key key) const { return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ull) >> 32) & mask_; }

    std::size_t mask_ = 0;
    std::vector<std::int32_t> place_{-1};
};

/// A set of blocks in key order. Nothing here is collective.
template <int Dim>
class BlockIndex {
  public:
    static constexpr unsigned children = Block<Dim>::corners;

    BlockIndex() = default;
    /// Ascending, no key twice.
    explicit BlockIndex(std::span<const Key> keys);
    /// Ascending by parent, none twice and none without blocks; `first` need not be set.
    explicit BlockIndex(std::vector<Family> families);

    /// Index of the block, or -1.
    std::int32_t find(Key key) const {
        const std::int32_t f = family(key >> Dim);
        const auto child = static_cast<unsigned>(key) & (children - 1);
        if (f < 0 || !families_[static_cast<std::size_t>(f)].has(child)) return -1;
        return families_[static_cast<std::size_t>(f)].index_of(child);
    }

    /// Which of families() has this parent, or -1.
    std::int32_t family(Key parent) const { return table_.find(families_, parent); }

    const std::vector<Family>& families() const { return families_; }  ///< ascending
    std::vector<Key> keys() const;                                     ///< of all blocks, ascending

  private:
    void insert_families();

    std::vector<Family> families_;
    FamilyTable table_;
};

}  // namespace moraine
