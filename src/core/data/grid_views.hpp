#pragma once
// What the kernels see of one rank's share of the grid, for one epoch. Plain pointers, by value.
//
// Own blocks 0..blocks are this rank's blocks of the topology in key order, empty ones too. Ghost
// blocks follow: foreign neighbours of own blocks. Node blocks hold the sums and values of the nodes
// of a block; own and upper neighbours of own blocks have one.

#include <cstddef>
#include <cstdint>

#include "core/data/block.hpp"
#include "core/data/vec.hpp"

namespace moraine {

template <int Dim>
struct BlockTable {
    int own;                                 ///< number of own blocks
    int ghosts;                              ///< number of ghost blocks
    const Vec<std::int32_t, Dim>* position;  ///< own: [blocks] from the domain's corner
    const std::int32_t* neighbour;           ///< own x offsets: own or ghost index, or -1
    const std::int32_t* node_block;          ///< own x corners: node block of block + delta
    const std::uint8_t* border;              ///< own: bit 0 a wall may fold or end it here
    int node_blocks;
    const Vec<std::int32_t, Dim>* node_position;  ///< node blocks
    const std::int32_t* source;                   ///< node block x corners: own or ghost block of c - delta, or -1
    const std::uint8_t* node_border;              ///< node blocks: has wall nodes
    const std::int32_t* kept_nodes = nullptr;     ///< node blocks: not negative: wanted though no own block has soil
};

/// Who is where: the list of each own block, sorted by cell.
template <int Dim>
struct ListView {
    const std::uint32_t* first;       ///< own + 1: start of the block's list
    const std::uint32_t* cell_first;  ///< own x (cells + 1): start of the cell within the block's list
    const std::uint32_t* slot;        ///< the lists

    MORAINE_HD std::uint32_t count(int block) const { return first[block + 1] - first[block]; }

    /// A slot that the loop over the block's list will come to some particles after entry k.
    MORAINE_HD std::uint32_t ahead(int block, std::uint32_t k) const {
        constexpr std::uint32_t distance = 8;
        return slot[k + distance < first[block + 1] ? k + distance : k];
    }
};

/// A mean over the mass of a node that its tiles sum in the force quad's idle lane: none, of the particles' mean stress
/// (pressure_smoothing.hpp), or of their volume per mass (particle_shifting.hpp).
enum class NodeMean { none, stress, volume };

/// Place of node n of a node block in the tile of the block at offset delta, or -1: that tile does not reach it.
template <int Dim>
MORAINE_HD int tile_node(int n, int delta, int width) {
    const int side = tile_side(width);
    int at = 0;
    for (int a = Dim - 1; a >= 0; --a) {
        const int x = (n >> (2 * a)) & 3;
        const int upper = Block<Dim>::corner(delta, a);
        if (upper && x >= width - 1) return -1;
        at = at * side + x + 4 * upper;
    }
    return at;
}

/// Where the tiles and node values of this step are: storage index by block, or -1.
template <class Real>
struct TileView {
    const std::int32_t* tile_of;  ///< own + ghosts
    Real* tiles;                  ///< [tile][node of tile][node_reals]
    const std::int32_t* node_of;  ///< node blocks
    Real* nodes;                  ///< [node block][node][node_reals]
};

/// Index of node n of an own block's tile among the stored nodes.
template <int Width, class Real, int Dim>
MORAINE_HD std::size_t stored_tile_node(const BlockTable<Dim>& table, const TileView<Real>& grid, int block, int n) {
    constexpr int side = tile_side(Width);
    int corner = 0, at = 0;
    for (int a = 0; a < Dim; ++a, n /= side) {
        const int x = n % side;
        corner |= (x >> 2) << a;
        at |= (x & 3) << (2 * a);
    }
    const std::int32_t node_block = table.node_block[block * Block<Dim>::corners + corner];
    return std::size_t(grid.node_of[node_block]) * Block<Dim>::cells + std::size_t(at);
}

}  // namespace moraine
