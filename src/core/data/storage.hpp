#pragma once
// Which blocks get a tile and which node blocks get values in this step: those that are used, counted by
// a prefix sum. Empty apron blocks cost nothing.

#include "core/data/grid_views.hpp"

namespace moraine {

template <int Dim>
struct MarkOccupied {
    ListView<Dim> list;
    std::uint32_t* used;  ///< own blocks

    MORAINE_HD void operator()(int block) const { used[block] = list.count(block) > 0; }
};

/// Node blocks that an occupied own block touches.
template <int Dim>
struct MarkNeeded {
    BlockTable<Dim> table;
    const std::int32_t* tile_of;
    std::uint32_t* used;  ///< node blocks

    MORAINE_HD void operator()(int c) const {
        used[c] = 0;
        for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
            const std::int32_t source = table.source[c * Block<Dim>::corners + delta];
            if (source >= 0 && source < table.own && tile_of[source] >= 0) used[c] = 1;
        }
    }
};

/// Storage index of what is used, from the prefix sum; -1: none. Items past `count` (ghosts) get theirs
/// when their tile comes.
struct PlaceTiles {
    int count;
    int first;  ///< storage indices below are taken
    const std::uint32_t* used;
    const std::uint32_t* place;
    std::int32_t* storage;

    MORAINE_HD void operator()(int i) const {
        storage[i] = i < count && used[i] ? first + static_cast<std::int32_t>(place[i]) : -1;
    }
};

}  // namespace moraine
