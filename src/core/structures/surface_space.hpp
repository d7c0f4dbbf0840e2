#pragma once
// What nodes find of surfaces that act where they are (core/surfaces/surface_geometry.hpp), for those that ask by node
// block.

#include <cstdint>

#include "core/data/vec.hpp"

namespace moraine {

/// What a node finds of surfaces, as those ask for it who are not at surfaces themselves.
struct SpaceNode {
    double distance;  ///< of the nearest [cells]
    double capacity;  ///< c_i
};

/// The nodes of node blocks near surfaces; of a scene without them, of none.
struct SurfaceSpace {
    const std::int32_t* near_of = nullptr;   ///< by node block; -1: no surface is near
    const SpaceNode* const* node = nullptr;  ///< [near node block]: of its nodes

    /// Of node n of a node block; null: no surface is near.
    MORAINE_HD const SpaceNode* of(int c, int n) const {
        return near_of && near_of[c] >= 0 ? node[near_of[c]] + n : nullptr;
    }
};

}  // namespace moraine
