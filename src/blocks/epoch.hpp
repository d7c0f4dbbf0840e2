#pragma once
// One rank's share of an epoch's topology: own blocks, ghosts, node blocks, and what the halo moves.
//
// Everything follows from the replicated topology, so both sides of a message derive the same list
// and nothing is negotiated. Ghosts are foreign neighbours of own blocks, grouped by owner, then in
// key order. Rank R receives from a foreign tile c the union over R's blocks b = c + eta of their
// overlap: per axis w - 1 layers of nodes where eta is not 0, else all 4 + w - 1.

#include <cstdint>
#include <vector>

#include "blocks/topology.hpp"

namespace moraine {

/// The tiles that go one way between two ranks: block indices and, for each, its node list.
struct TileList {
    std::vector<std::int32_t> block;   ///< own (send) or ghost (receive) index
    std::vector<std::uint32_t> first;  ///< tiles + 1: start of the tile's nodes
    std::vector<std::uint16_t> node;   ///< nodes of a tile, ascending
};

struct PeerHalo {
    int rank;
    TileList send;
    TileList receive;
    std::int32_t ghost_begin;  ///< ghosts owned by this peer
    std::int32_t ghost_end;
};

template <int Dim>
struct EpochTables {
    std::int64_t serial = 0;  ///< of its making by NextEpoch; 0: made otherwise
    std::vector<Key> own;     ///< keys, ascending
    std::vector<Key> ghost;   ///< keys
    std::vector<std::int32_t> ghost_owner;
    std::vector<Vec<std::int32_t, Dim>> position;  ///< own
    std::vector<std::int32_t> neighbour;           ///< own x offsets: own, own + ghost, or -1
    std::vector<std::uint8_t> border;              ///< own
    std::vector<std::uint64_t>
        guard_layer;            ///< own: bit per cell, near a block that there is not (blocks/guard_layer.hpp)
    std::vector<Key> node_key;  ///< node blocks, ascending
    std::vector<Vec<std::int32_t, Dim>> node_position;
    std::vector<std::uint8_t> node_border;
    std::vector<std::uint8_t>
        kept_nodes;  ///< whose values are wanted whoever touches them; empty: none (Patch::keep_nodes)
    std::vector<std::int32_t> node_block;  ///< own x corners
    std::vector<std::int32_t> source;      ///< node block x corners
    std::vector<PeerHalo> peers;           ///< by rank
    std::vector<std::int32_t> boundary;    ///< own blocks that some peer needs
    std::vector<std::int32_t> interior;    ///< the others

    /// Index of an own block, or -1.
    std::int32_t find_own(Key key) const;
};

/// Not collective.
template <int Dim>
EpochTables<Dim> make_epoch(const Topology<Dim>& topology, const DomainBlocks<Dim>& domain, const Stencil& stencil,
                            int rank);

}  // namespace moraine
