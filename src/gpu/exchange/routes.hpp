#pragma once
// An epoch's halo lists on the device: which tiles travel between this rank and its peers, and which of their nodes.
//
// Both sides have the same lists in the same order (blocks/epoch.hpp), so a tile is told by its number in a peer's
// list.

#include <utility>

#include "blocks/epoch.hpp"
#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

/// One way. Tiles of all peers stand in one list, peer by peer.
struct Route {
    int peers;
    int tiles;
    const std::uint32_t* peer_first;  ///< peers + 1: a peer's tiles
    const std::int32_t* peer;         ///< by tile
    const std::int32_t* block;        ///< by tile: own index (send) or ghost index (receive)
    const std::uint32_t* node_first;  ///< tiles + 1
    const std::uint16_t* node;        ///< nodes of a tile that travel
    const std::int32_t* ghost_first;  ///< peers + 1: ghosts of a peer
};

class Routes {
  public:
    /// There when the stream has been waited for.
    template <int Dim>
    void upload(const EpochTables<Dim>& tables, cudaStream_t stream) {
        std::vector<std::int32_t> ghost_first;
        for (const PeerHalo& peer : tables.peers) ghost_first.push_back(peer.ghost_begin);
        ghost_first.push_back(static_cast<std::int32_t>(tables.ghost.size()));
        ghost_first_.assign(ghost_first, stream);
        send_.upload(tables.peers, &PeerHalo::send, stream);
        receive_.upload(tables.peers, &PeerHalo::receive, stream);
    }
    void swap(Routes& other) {
        send_.swap(other.send_);
        receive_.swap(other.receive_);
        ghost_first_.swap(other.ghost_first_);
    }
    Route send() const { return send_.view(ghost_first_.data()); }
    Route receive() const { return receive_.view(ghost_first_.data()); }

  private:
    struct Way {
        std::size_t peers = 0, tiles = 0;
        PoolArray<std::uint32_t> peer_first, node_first;
        PoolArray<std::int32_t> peer, block;
        PoolArray<std::uint16_t> node;

        void swap(Way& other) {
            std::swap(peers, other.peers);
            std::swap(tiles, other.tiles);
            peer_first.swap(other.peer_first);
            node_first.swap(other.node_first);
            peer.swap(other.peer);
            block.swap(other.block);
            node.swap(other.node);
        }

        void upload(const std::vector<PeerHalo>& halos, TileList PeerHalo::*list, cudaStream_t stream) {
            std::vector<std::uint32_t> peer_firsts{0}, node_firsts{0};
            std::vector<std::int32_t> of_peer, blocks;
            std::vector<std::uint16_t> nodes;
            for (std::size_t k = 0; k < halos.size(); ++k) {
                const TileList& tiles_of = halos[k].*list;
                const auto before = static_cast<std::uint32_t>(nodes.size());
                of_peer.insert(of_peer.end(), tiles_of.block.size(), static_cast<std::int32_t>(k));
                blocks.insert(blocks.end(), tiles_of.block.begin(), tiles_of.block.end());
                nodes.insert(nodes.end(), tiles_of.node.begin(), tiles_of.node.end());
                for (std::size_t t = 1; t < tiles_of.first.size(); ++t)
                    node_firsts.push_back(before + tiles_of.first[t]);
                peer_firsts.push_back(static_cast<std::uint32_t>(blocks.size()));
            }
            peers = halos.size(), tiles = blocks.size();
            peer_first.assign(peer_firsts, stream), node_first.assign(node_firsts, stream);
            peer.assign(of_peer, stream), block.assign(blocks, stream), node.assign(nodes, stream);
        }
        Route view(const std::int32_t* ghosts) const {
            return {static_cast<int>(peers),
                    static_cast<int>(tiles),
                    peer_first.data(),
                    peer.data(),
                    block.data(),
                    node_first.data(),
                    node.data(),
                    ghosts};
        }
    };

    Way send_, receive_;
    PoolArray<std::int32_t> ghost_first_;
};

/// What ranks have sent, and what the next messages need; on the device, added to by kernels.
struct Counters {
    std::uint64_t halo_bytes;
    std::uint64_t crossed;             ///< particles that walked to other ranks
    std::uint32_t stored;              ///< slots in use: those at or above are free
    std::uint32_t migration_bound[2];  ///< of a block, of a pair (engine/agreement.hpp), since the last report
};

}  // namespace moraine::gpu
