#pragma once
// Halo: the unsummed tiles that other ranks need travel to them, once per round.
//
// One message per peer: occupancy of its tiles, one byte each, with whether the block sleeps, then the shared nodes of
// the tiles that exist, node_sums reals each, and last lanes of the second quad (lanes_besides());
// in the first round of a step with structures the same nodes of the gap tiles of those (contact_pairs.hpp). Both sides
// know the lists from the epoch's tables. A received tile is stored as the tile of its ghost block, so that nodes sum
// own and foreign tiles by one rule.

#include "blocks/contact_pairs.hpp"
#include "blocks/epoch.hpp"
#include "comm/point_to_point.hpp"
#include "core/data/grid_views.hpp"
#include "core/particles/particle_bytes.hpp"

namespace moraine {

/// The gap tiles of a step, and which there are.
template <int Dim>
struct GapShare {
    const ContactPairs<Dim>* pairs;
    NodeGap* tiles;
};

/// Last lanes of a node's second quad that tiles have besides node_sums: a mean (NodeMean), or what water has.
template <int Dim>
int lanes_besides(const auto& method) {
    if (method.pores()) return quad - Dim;
    return method.fluid() || method.grid_bulk() ? 1 : 0;
}

template <class Real, int Dim>
class Halo {
  public:
    /// Not collective; buffers for one epoch.
    Halo(const EpochTables<Dim>& tables, PointToPoint& messages, int width, int besides = 0)
        : tables_(tables),
          messages_(messages),
          tile_nodes_(static_cast<std::size_t>(power<Dim>(tile_side(width)))),
          besides_(besides) {
        for (const PeerHalo& peer : tables.peers) {
            out_.emplace_back(capacity(peer.send));
            in_.emplace_back(capacity(peer.receive));
        }
    }

    /// Makes space for the gaps of new pairs. Not collective.
    void reserve(const ContactPairs<Dim>& pairs) {
        for (std::size_t k = 0; k < out_.size(); ++k) {
            const PeerHalo& peer = tables_.peers[k];
            out_[k].resize(capacity(peer.send) + gap_bytes(peer.send, pairs, 0));
            in_[k].resize(capacity(peer.receive) + gap_bytes(peer.receive, pairs, tables_.own.size()));
        }
    }

    /// Packs and sends the boundary tiles; gaps: null in rounds without; asleep: which blocks sleep, own ones first,
    /// then ghosts, or null. Each start() meets one finish(); collective over peers.
    void start(const TileView<Real>& grid, const GapShare<Dim>* gaps = nullptr, const std::uint8_t* asleep = nullptr) {
        sends_.clear();
        receives_.clear();
        for (std::size_t k = 0; k < out_.size(); ++k) {
            const std::int64_t bytes = pack(tables_.peers[k].send, grid, gaps, asleep, out_[k].data());
            sends_.push_back({tables_.peers[k].rank, out_[k].data(), bytes, static_cast<std::int64_t>(out_[k].size())});
            receives_.push_back({tables_.peers[k].rank, in_[k].data(), 0, static_cast<std::int64_t>(in_[k].size())});
            bytes_ += bytes;
        }
        messages_.start(sends_, receives_);
    }

    /// Waits, and puts the foreign tiles in place; tile_of is that of own blocks, then ghosts.
    void finish(const TileView<Real>& grid, std::int32_t* tile_of, const GapShare<Dim>* gaps = nullptr,
                std::uint8_t* asleep = nullptr) {
        messages_.finish();
        for (std::size_t k = 0; k < in_.size(); ++k) {
            const TileList& list = tables_.peers[k].receive;
            for (std::size_t t = 0; asleep && t < list.block.size(); ++t)
                asleep[tables_.own.size() + static_cast<std::size_t>(list.block[t])] = in_[k][t] == sleeping_tile;
            const std::byte* rest = unpack(tables_.peers[k].receive, grid, tile_of, in_[k].data());
            if (gaps) unpack_gaps(tables_.peers[k].receive, *gaps, tile_of, rest);
        }
    }

    std::int64_t bytes() const { return bytes_; }  ///< sent so far by this rank in this epoch

  private:
    static constexpr std::byte sleeping_tile{2};  ///< its occupancy; of others 1, or 0: there is none

    std::size_t capacity(const TileList& list) const {
        const std::size_t sums = node_sums<Dim> + static_cast<std::size_t>(besides_);
        return padded(list.block.size()) + list.node.size() * sums * sizeof(Real);
    }

    static std::size_t gap_bytes(const TileList& list, const ContactPairs<Dim>& pairs, std::size_t first_block) {
        std::size_t nodes = 0;
        for (std::size_t t = 0; t < list.block.size(); ++t)
            nodes += static_cast<std::size_t>(list.first[t + 1] - list.first[t]) *
                     static_cast<std::size_t>(pairs.of_block(first_block + static_cast<std::size_t>(list.block[t])));
        return nodes * sizeof(NodeGap);
    }

    /// Calls f(gap, at) for the listed nodes of the gap tiles of a block: `at` counts on.
    template <class F>
    void each_gap(const TileList& list, std::size_t t, const GapShare<Dim>& gaps, std::size_t block, std::size_t& at,
                  const F& f) const {
        const auto count = static_cast<std::size_t>(gaps.pairs->structures());
        for (std::size_t k = 0; k < count; ++k) {
            const std::int32_t tile = gaps.pairs->tile_of()[block * count + k];
            if (tile < 0) continue;
            NodeGap* nodes = gaps.tiles + static_cast<std::size_t>(tile) * tile_nodes_;
            for (std::uint32_t n = list.first[t]; n < list.first[t + 1]; ++n) f(nodes[list.node[n]], at++);
        }
    }

    std::int64_t pack(const TileList& list, const TileView<Real>& grid, const GapShare<Dim>* gaps,
                      const std::uint8_t* asleep, std::byte* to) const {
        Real* values = reinterpret_cast<Real*>(to + padded(list.block.size()));
        const Real* begin = values;
        for (std::size_t t = 0; t < list.block.size(); ++t) {
            const std::int32_t tile = grid.tile_of[list.block[t]];
            to[t] = static_cast<std::byte>(tile >= 0);
            if (tile < 0) continue;
            if (asleep && asleep[list.block[t]]) to[t] = sleeping_tile;
            const Real* from = grid.tiles + static_cast<std::size_t>(tile) * tile_nodes_ * node_reals;
            for (std::uint32_t n = list.first[t]; n < list.first[t + 1]; ++n) {
                const Real* node = from + list.node[n] * node_reals;
                for (int q = 0; q <= Dim; ++q) *values++ = node[q];
                for (int q = 0; q < Dim; ++q) *values++ = node[quad + q];
                for (int q = quad - besides_; q < quad; ++q) *values++ = node[quad + q];
            }
        }
        std::size_t packed = 0;
        auto* rest = reinterpret_cast<NodeGap*>(values);
        for (std::size_t t = 0; gaps && t < list.block.size(); ++t)
            if (to[t] != std::byte{0})
                each_gap(list, t, *gaps, static_cast<std::size_t>(list.block[t]), packed,
                         [&](const NodeGap& gap, std::size_t at) { rest[at] = gap; });
        return static_cast<std::int64_t>(padded(list.block.size()) +
                                         static_cast<std::size_t>(values - begin) * sizeof(Real) +
                                         packed * sizeof(NodeGap));
    }

    void unpack_gaps(const TileList& list, const GapShare<Dim>& gaps, const std::int32_t* tile_of,
                     const std::byte* from) const {
        const auto* rest = reinterpret_cast<const NodeGap*>(from);
        std::size_t unpacked = 0;
        for (std::size_t t = 0; t < list.block.size(); ++t) {
            const std::size_t ghost = tables_.own.size() + static_cast<std::size_t>(list.block[t]);
            if (tile_of[ghost] >= 0)
                each_gap(list, t, gaps, ghost, unpacked, [&](NodeGap& gap, std::size_t at) { gap = rest[at]; });
        }
    }

    /// Returns where the values end.
    const std::byte* unpack(const TileList& list, const TileView<Real>& grid, std::int32_t* tile_of,
                            const std::byte* from) const {
        const Real* values = reinterpret_cast<const Real*>(from + padded(list.block.size()));
        for (std::size_t t = 0; t < list.block.size(); ++t) {
            const std::int32_t ghost = list.block[t];
            const bool here = from[t] != std::byte{0};
            tile_of[tables_.own.size() + static_cast<std::size_t>(ghost)] = here ? ghost : -1;
            if (!here) continue;
            Real* to = grid.tiles + static_cast<std::size_t>(ghost) * tile_nodes_ * node_reals;
            for (std::uint32_t n = list.first[t]; n < list.first[t + 1]; ++n) {
                Real* node = to + list.node[n] * node_reals;
                for (int q = 0; q <= Dim; ++q) node[q] = *values++;
                for (int q = 0; q < Dim; ++q) node[quad + q] = *values++;
                for (int q = Dim + 1; q < quad; ++q) node[q] = Real(0);
                for (int q = Dim; q < quad; ++q) node[quad + q] = Real(0);
                for (int q = quad - besides_; q < quad; ++q) node[quad + q] = *values++;
            }
        }
        return reinterpret_cast<const std::byte*>(values);
    }

    const EpochTables<Dim>& tables_;
    PointToPoint& messages_;
    const std::size_t tile_nodes_;
    const int besides_;
    std::vector<std::vector<std::byte>> out_, in_;
    std::vector<Parcel> sends_, receives_;
    std::int64_t bytes_ = 0;
};

}  // namespace moraine
