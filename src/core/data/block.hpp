#pragma once
// Blocks of 4^d cells, tiles of the nodes that a block's particles touch, and the numbering of both.
//
// Cell of a block:  x + 4 y + 16 z.   Node of a tile: x + T (y + T z), T = 4 + width - 1.
// Neighbour offset eta in {-1, 0, 1}^d has code sum (eta_a + 1) 3^a; the centre is the block itself.
// Upper corner delta in {0, 1}^d has code sum delta_a 2^a.
// One node holds two quads of sums or values: (mass, momentum) and (force); after the node kernel
// (-, velocity) and (-, change of velocity). Unused lanes are zero. A quad is one vector register.

#include <cstdint>

#include "core/data/vec.hpp"

namespace moraine {

template <int Dim>
struct Block {
    static constexpr int side = 4;
    static constexpr int cells = Dim == 2 ? 16 : 64;
    static constexpr int offsets = Dim == 2 ? 9 : 27;
    static constexpr int corners = Dim == 2 ? 4 : 8;
    static constexpr int centre = (offsets - 1) / 2;
    static constexpr std::uint8_t gone = 255;  ///< offset code of a particle that left through an open wall

    /// Component `axis` of neighbour offset `code`: -1, 0 or 1.
    static constexpr MORAINE_HD int offset(int code, int axis) {
        return (axis == 0 ? code : (axis == 1 ? code / 3 : code / 9)) % 3 - 1;
    }
    static constexpr MORAINE_HD int opposite(int code) { return offsets - 1 - code; }
    static constexpr MORAINE_HD int corner(int code, int axis) { return (code >> axis) & 1; }
    /// Bit per offset code: where a particle in `cell` can be after a step, in which nothing goes a whole cell.
    static constexpr MORAINE_HD std::uint32_t reach(int cell) {
        std::uint32_t reached = 1;
        for (int axis = 0, stride = 1; axis < Dim; ++axis, stride *= 3) {
            const int c = (cell >> (2 * axis)) & 3;
            reached = reached << stride | (c == 0 ? reached : 0) | (c == side - 1 ? reached << (2 * stride) : 0);
        }
        return reached;
    }
};

inline constexpr int quad = 4;
inline constexpr int node_reals = 2 * quad;  ///< reals stored per node

/// Nodes along one axis of a tile.
constexpr MORAINE_HD int tile_side(int width) {
    return 4 + width - 1;
}

template <int Dim>
constexpr MORAINE_HD int power(int base) {
    return Dim == 2 ? base * base : base * base * base;
}

/// Where a node's quads carry numbers: 1 + Dim sums in the first, Dim in the second.
template <int Dim>
inline constexpr int node_sums = 1 + 2 * Dim;

}  // namespace moraine
