#pragma once
// What a partition sends in one exchange of halos: tiles, bytes and neighbours of every rank, counted as an epoch's
// tables do (blocks/epoch.hpp) but for all ranks at once, from the blocks alone.
//
// The tile of an occupied block goes to every other rank that owns a neighbour of it, empty neighbours (the
// apron) included; what travels is the union of the overlaps. An empty neighbour belongs to whom a static
// partitioner says, else to the owner of its first occupied neighbour. One byte a tile says whether it is there.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "blocks/block_index.hpp"
#include "comm/host_groups.hpp"
#include "replay/interval.hpp"

namespace moraine {

struct HaloForecast {
    std::int64_t tiles = 0;  ///< sent in all; a tile once to each rank
    std::int64_t bytes = 0;
    std::int64_t busiest_bytes = 0;  ///< of the rank that sends most
    std::int64_t face_cut = 0;       ///< faces between occupied blocks of different ranks
    double neighbours_mean = 0;      ///< over all ranks, idle ones included
    std::int32_t neighbours_max = 0;

    /// What a rank sends to ranks of its host, and to those of others.
    struct Sent {
        std::int32_t neighbours_within = 0, neighbours_between = 0;
        std::int64_t bytes_within = 0, bytes_between = 0;
    };
    std::vector<Sent> sent;          ///< of each rank, where hosts were given
    std::int64_t tiles_between = 0;  ///< of the tiles, those that go to other hosts
};

/// The blocks around the occupied ones; serves any number of partitions.
class HaloSurroundings {
  public:
    /// `blocks` must outlive it. Not collective.
    HaloSurroundings(const Layout& layout, std::span<const BlockLoad> blocks);

    /// `owners` of the blocks; `static_owner`: nothing, or the rank of a place. `node_bytes`: of a node.
    /// `hosts`: of each rank, or nothing: then it is not asked what stays on one.
    HaloForecast halo(std::span<const std::int32_t> owners, const Partitioner& partitioner, int ranks, int node_bytes,
                      std::span<const std::int32_t> hosts = {}) const;

  private:
    std::int32_t at(std::size_t block, int code) const {
        return table_.empty() ? look_up(blocks_[block].key, code) : table_[block * offsets_ + code];
    }
    std::int32_t look_up(Key key, int code) const;
    std::vector<std::int32_t> owners_of_apron(std::span<const std::int32_t> owners,
                                              const Partitioner& partitioner) const;
    void look_around(std::size_t block);
    void find_apron();

    const Layout layout_;
    std::span<const BlockLoad> blocks_;
    std::size_t offsets_;
    BlockIndex<3> occupied_, empty_;           // families of eight serve 2-D keys as well
    std::vector<Key> apron_;                   // empty neighbours, sorted
    std::vector<std::int32_t> inherits_from_;  // of each: its first occupied neighbour
    std::vector<std::int32_t> table_;  // blocks x offsets: block, blocks + apron, or -1; not for millions of blocks
};

}  // namespace moraine
