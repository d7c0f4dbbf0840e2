#pragma once
// Halo: the unsummed tiles that other ranks need travel to them, once per round.
//
// One message per peer: occupancy of its tiles, one byte each, then the shared nodes of the tiles
// that exist, node_sums reals each, one more where they have a mean (NodeMean). Both sides know the lists from the
// epoch's tables. A received tile is stored as the tile of its ghost block, so that nodes sum own and foreign tiles by
// one rule.

#include "comm/epoch.hpp"
#include "comm/point_to_point.hpp"
#include "core/grid_views.hpp"
#include "core/particle_bytes.hpp"

namespace moraine {

template <class Real, int Dim>
class Halo {
  public:
    /// Not collective; buffers for one epoch.
    Halo(const EpochTables<Dim>& tables, PointToPoint& messages, int width, bool with_mean = false)
        : tables_(tables), messages_(messages), with_mean_(with_mean) {
        tile_reals_ = static_cast<std::size_t>(power<Dim>(tile_side(width)) * node_reals);
        for (const PeerHalo& peer : tables.peers) {
            out_.emplace_back(capacity(peer.send));
            in_.emplace_back(capacity(peer.receive));
        }
    }

    /// Packs and sends the boundary tiles. Each start() meets one finish(); collective over peers.
    void start(const TileView<Real>& grid) {
        sends_.clear();
        receives_.clear();
        for (std::size_t k = 0; k < out_.size(); ++k) {
            const std::int64_t bytes = pack(tables_.peers[k].send, grid, out_[k].data());
            sends_.push_back({tables_.peers[k].rank, out_[k].data(), bytes, static_cast<std::int64_t>(out_[k].size())});
            receives_.push_back({tables_.peers[k].rank, in_[k].data(), 0, static_cast<std::int64_t>(in_[k].size())});
            bytes_ += bytes;
        }
        messages_.start(sends_, receives_);
    }

    /// Waits, and puts the foreign tiles in place; tile_of is that of own blocks, then ghosts.
    void finish(const TileView<Real>& grid, std::int32_t* tile_of) {
        messages_.finish();
        for (std::size_t k = 0; k < in_.size(); ++k) unpack(tables_.peers[k].receive, grid, tile_of, in_[k].data());
    }

    std::int64_t bytes() const { return bytes_; }  ///< sent so far by this rank in this epoch

  private:
    std::size_t capacity(const TileList& list) const {
        const std::size_t sums = node_sums<Dim> + (with_mean_ ? 1 : 0);
        return padded(list.block.size()) + list.node.size() * sums * sizeof(Real);
    }

    std::int64_t pack(const TileList& list, const TileView<Real>& grid, std::byte* to) const {
        Real* values = reinterpret_cast<Real*>(to + padded(list.block.size()));
        const Real* begin = values;
        for (std::size_t t = 0; t < list.block.size(); ++t) {
            const std::int32_t tile = grid.tile_of[list.block[t]];
            to[t] = static_cast<std::byte>(tile >= 0);
            if (tile < 0) continue;
            const Real* from = grid.tiles + static_cast<std::size_t>(tile) * tile_reals_;
            for (std::uint32_t n = list.first[t]; n < list.first[t + 1]; ++n) {
                const Real* node = from + list.node[n] * node_reals;
                for (int q = 0; q <= Dim; ++q) *values++ = node[q];
                for (int q = 0; q < Dim; ++q) *values++ = node[quad + q];
                if (with_mean_) *values++ = node[2 * quad - 1];
            }
        }
        return static_cast<std::int64_t>(padded(list.block.size()) +
                                         static_cast<std::size_t>(values - begin) * sizeof(Real));
    }

    void unpack(const TileList& list, const TileView<Real>& grid, std::int32_t* tile_of, const std::byte* from) const {
        const Real* values = reinterpret_cast<const Real*>(from + padded(list.block.size()));
        for (std::size_t t = 0; t < list.block.size(); ++t) {
            const std::int32_t ghost = list.block[t];
            const bool here = from[t] != std::byte{0};
            tile_of[tables_.own.size() + static_cast<std::size_t>(ghost)] = here ? ghost : -1;
            if (!here) continue;
            Real* to = grid.tiles + static_cast<std::size_t>(ghost) * tile_reals_;
            for (std::uint32_t n = list.first[t]; n < list.first[t + 1]; ++n) {
                Real* node = to + list.node[n] * node_reals;
                for (int q = 0; q <= Dim; ++q) node[q] = *values++;
                for (int q = 0; q < Dim; ++q) node[quad + q] = *values++;
                for (int q = Dim + 1; q < quad; ++q) node[q] = Real(0);
                for (int q = Dim; q < quad; ++q) node[quad + q] = Real(0);
                if (with_mean_) node[2 * quad - 1] = *values++;
            }
        }
    }

    const EpochTables<Dim>& tables_;
    PointToPoint& messages_;
    const bool with_mean_;
    std::size_t tile_reals_;
    std::vector<std::vector<std::byte>> out_, in_;
    std::vector<Parcel> sends_, receives_;
    std::int64_t bytes_ = 0;
};

}  // namespace moraine
