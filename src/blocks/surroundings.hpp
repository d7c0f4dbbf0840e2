#pragma once
// The surroundings of a family of blocks: its 2^d blocks and the layer of blocks around them, 4^d places.
//
// Places are numbered like cells, x + 4 y + 16 z; the family's own are 1 and 2 on each axis, so the neighbour of a
// child at any offset is a place that a constant table names. Places lie in 3^d families (slots), which are looked up
// once. Periodic axes wrap block by block: where the count is odd the families there are cut by the seam, and a place
// is another child of another slot than elsewhere; still no axis has more than three parents.

#include <array>
#include <bit>

#include "blocks/topology.hpp"

namespace moraine {

/// Sets of places: bit p is place p.
using Places = std::uint64_t;

template <int Dim>
struct PlaceTables {
    static constexpr unsigned children = Block<Dim>::corners;

    std::array<std::array<std::uint8_t, Block<Dim>::offsets>, children> at{};  ///< of the neighbour at an offset code
    std::array<Places, children> around{};                                     ///< of the child and all its neighbours
    std::array<Places, children> upwards{};                                    ///< of the child and its upper corners
    std::array<Places, children> downwards{};                                  ///< of the child and its lower corners

    constexpr PlaceTables() {
        for (unsigned child = 0; child < children; ++child)
            for (int code = 0; code < Block<Dim>::offsets; ++code) {
                bool up = true, down = true;
                for (int a = Dim - 1; a >= 0; --a) {
                    const int eta = Block<Dim>::offset(code, a);
                    at[child][code] = static_cast<std::uint8_t>(4 * at[child][code] + 1 + (child >> a & 1u) + eta);
                    up = up && eta >= 0;
                    down = down && eta <= 0;
                }
                around[child] |= Places(1) << at[child][code];
                if (up) upwards[child] |= Places(1) << at[child][code];
                if (down) downwards[child] |= Places(1) << at[child][code];
            }
    }

    /// Union over the children of a mask of what `reach`, one of the tables, says of each.
    static constexpr Places of(std::uint32_t mask, const std::array<Places, children>& reach) {
        Places all = 0;
        for (unsigned child = 0; child < children; ++child)
            if (mask >> child & 1u) all |= reach[child];
        return all;
    }
};

template <int Dim>
inline constexpr PlaceTables<Dim> place_tables{};

/// Offset code of upper (sign 1) or lower (-1) corner delta.
template <int Dim>
constexpr int corner_code(int delta, int sign) {
    int code = 0;
    for (int a = Dim - 1; a >= 0; --a) code = 3 * code + 1 + sign * Block<Dim>::corner(delta, a);
    return code;
}

/// Which places there are: blocks of the domain, or also those beyond its ends (periodic axes have none).
enum class Ends { closed, open };

template <int Dim>
class Surroundings {
  public:
    static constexpr int places = Dim == 2 ? 16 : 64;
    static constexpr int slots = Block<Dim>::offsets;
    struct Cell {
        std::uint8_t slot;
        std::uint8_t child;
    };

    Surroundings(const DomainBlocks<Dim>& domain, Key parent, Ends ends);

    Key parent(int slot) const {
        Key key = axis_[0].parent[slot % 3] | axis_[1].parent[slot / 3 % 3];
        if constexpr (Dim == 3) key |= axis_[2].parent[slot / 9];
        return key;
    }
    Places inside() const { return inside_; }
    /// May some of these places lie in the slot?
    bool touches(int slot, Places some) const {
        return cut_ || (some & places_of_slot[static_cast<std::size_t>(slot)]);
    }
    const Cell& cell(int place) const { return cut_ ? cells_[place] : regular[static_cast<std::size_t>(place)]; }

  private:
    /// Four places in a row: the parents (bits of their keys) in which they lie, and which is where.
    struct Axis {
        std::array<Key, 3> parent;
        std::array<std::uint8_t, 4> slot{0, 1, 1, 2};
        std::array<std::uint8_t, 4> child{1, 0, 1, 0};
        unsigned inside = 15;
    };
    static constexpr std::array<Cell, places> cells_of(const std::array<Axis, Dim>& axes) {
        std::array<Cell, places> cells{};
        for (int p = 0; p < places; ++p)
            for (int a = Dim - 1; a >= 0; --a) {
                const int k = p >> (2 * a) & 3;
                Cell& cell = cells[p];
                cell.slot = static_cast<std::uint8_t>(3 * cell.slot + axes[a].slot[k]);
                cell.child = static_cast<std::uint8_t>(2 * cell.child + axes[a].child[k]);
            }
        return cells;
    }
    static const std::array<Cell, places> regular;
    static const std::array<Places, slots> places_of_slot;  ///< where no seam cuts families

    /// Sets an axis at an end of the domain.
    void set_end(const DomainBlocks<Dim>& domain, int a, std::int32_t first);

    std::array<Axis, Dim> axis_{};
    std::array<Cell, places> cells_;  ///< where a seam cuts families
    Places inside_ = ~Places(0) >> (64 - places);
    bool cut_ = false;
};

/// Indices in `index` of the blocks at the places of `wanted`, -1 where there is none and at all other places.
template <int Dim>
std::array<std::int32_t, Surroundings<Dim>::places> blocks_at(const BlockIndex<Dim>& index,
                                                              const Surroundings<Dim>& near, Places wanted) {
    wanted &= near.inside();
    std::array<Family, Surroundings<Dim>::slots> families;
    for (int slot = 0; slot < Surroundings<Dim>::slots; ++slot) {
        const std::int32_t f = near.touches(slot, wanted) ? index.family(near.parent(slot)) : -1;
        families[static_cast<std::size_t>(slot)] =
            f < 0 ? Family{0, 0, 0} : index.families()[static_cast<std::size_t>(f)];
    }
    std::array<std::int32_t, Surroundings<Dim>::places> blocks;
    blocks.fill(-1);
    for (; wanted != 0; wanted &= wanted - 1) {
        const int p = std::countr_zero(wanted);
        const auto [slot, child] = near.cell(p);
        if (families[slot].has(child)) blocks[static_cast<std::size_t>(p)] = families[slot].index_of(child);
    }
    return blocks;
}

}  // namespace moraine
