#pragma once
// Migration: particles that walk into a block of another rank.
//
// One message per peer and step: a header with the count, then up to `capacity` records (capacity follows
// from the epoch's tables, so both sides know it); what does not fit follows in a second message of
// known size, never lost. A record is the source block's key, the move, and all columns. Records
// travel in (source block, list) order: that is all the binning rule needs.

#include <cstring>

#include "blocks/patch.hpp"
#include "comm/point_to_point.hpp"
#include "core/particles/particle_bytes.hpp"

namespace moraine {

template <class Space, class Real, int Dim>
class Migration {
  public:
    using Share = Patch<Space, Real, Dim>;

    /// Not collective; buffers for one epoch.
    Migration(Share& patch, PointToPoint& messages) : patch_(patch), messages_(messages) {
        for (const PeerHalo& peer : patch.tables().peers) {
            capacities_out_.push_back(records_per_tile * peer.send.block.size());
            capacities_in_.push_back(records_per_tile * peer.receive.block.size());
        }
        out_.resize(capacities_out_.size());
        in_.resize(capacities_in_.size());
    }

    /// Sends this step's outgoing particles to the ranks they go to. Calls gone(slot) for those that left through
    /// an open wall. Collective over peers.
    template <class Gone>
    void start(const Gone& gone) {
        patch_.collect_outgoing();
        sort_out(gone);
        const std::vector<ColumnBytes> columns = patch_.particles.columns();
        sends_.clear();
        receives_.clear();
        for (std::size_t k = 0; k < out_.size(); ++k) {
            const std::size_t n = outgoing_[k].slot.size();
            const std::size_t now = std::min(n, capacities_out_[k]);
            const int rank = patch_.tables().peers[k].rank;
            const auto capacity = static_cast<std::int64_t>(message_bytes(columns, capacities_out_[k]));
            out_[k].resize(static_cast<std::size_t>(capacity));
            const auto total = static_cast<std::int64_t>(n);
            std::memcpy(out_[k].data(), &total, 8);
            const auto bytes =
                static_cast<std::int64_t>(pack(columns, outgoing_[k], 0, now, out_[k].data() + 8) - out_[k].data());
            sends_.push_back({rank, out_[k].data(), bytes, capacity});
            in_[k].resize(message_bytes(columns, capacities_in_[k]));
            receives_.push_back({rank, in_[k].data(), 0, static_cast<std::int64_t>(in_[k].size())});
            crossed_ += total;
            bytes_ += bytes;
        }
        messages_.start(sends_, receives_);
    }

    /// Takes in the incoming particles and bins all lists anew. Collective over peers.
    void finish() {
        messages_.finish();
        const std::vector<std::vector<std::byte>> rest = exchange_rest();
        for (Outgoing& o : outgoing_) patch_.give_slots(o.slot);
        patch_.give_slots(gone_);
        std::vector<OutgoingParticle> outgoing;
        std::vector<std::uint32_t> first(patch_.tables().ghost.size() + 1, 0);
        for (std::size_t k = 0; k < in_.size(); ++k) {
            std::int64_t total = 0;
            std::memcpy(&total, in_[k].data(), 8);
            const std::size_t now = std::min(static_cast<std::size_t>(total), capacities_in_[k]);
            unpack(now, in_[k].data() + 8, outgoing, first);
            if (static_cast<std::size_t>(total) > now)
                unpack(static_cast<std::size_t>(total) - now, rest[k].data(), outgoing, first);
        }
        for (std::size_t g = 1; g < first.size(); ++g) first[g] += first[g - 1];
        patch_.make_lists(outgoing, first);
    }

    std::int64_t crossed() const { return crossed_; }  ///< particles sent so far
    std::int64_t bytes() const { return bytes_; }

  private:
    static constexpr std::size_t records_per_tile = 32;

    struct Outgoing {
        std::vector<std::uint64_t> key;
        std::vector<std::uint16_t> move;
        std::vector<std::uint32_t> slot;
    };

    static std::size_t record_bytes(const std::vector<ColumnBytes>& columns, std::size_t n) {
        return 8 * n + padded(2 * n) + rows_bytes(columns, n);
    }
    static std::size_t message_bytes(const std::vector<ColumnBytes>& columns, std::size_t n) {
        return 8 + record_bytes(columns, n);
    }

    template <class Gone>
    void sort_out(const Gone& gone) {
        const EpochTables<Dim>& tables = patch_.tables();
        outgoing_.assign(tables.peers.size(), {});
        gone_.clear();
        for (int b = 0; b < patch_.own(); ++b)
            for (const OutgoingParticle& l : patch_.outgoing_of(b)) {
                const int code = move_code(l.move);
                if (code == Block<Dim>::gone) {
                    gone(l.slot);
                    gone_.push_back(l.slot);
                    continue;
                }
                const std::int32_t to = tables.neighbour[static_cast<std::size_t>(b * Block<Dim>::offsets + code)];
                if (to < patch_.own()) continue;
                Outgoing& o = outgoing_[peer_of(to - patch_.own())];
                o.key.push_back(tables.own[static_cast<std::size_t>(b)]);
                o.move.push_back(l.move);
                o.slot.push_back(l.slot);
            }
    }

    std::size_t peer_of(std::int32_t ghost) const {
        const auto& peers = patch_.tables().peers;
        std::size_t k = 0;
        while (ghost >= peers[k].ghost_end) ++k;
        return k;
    }

    static std::byte* pack(const std::vector<ColumnBytes>& columns, const Outgoing& o, std::size_t from, std::size_t to,
                           std::byte* at) {
        const std::size_t n = to - from;
        if (n == 0) return at;
        std::memcpy(at, o.key.data() + from, 8 * n);
        std::memcpy(at + 8 * n, o.move.data() + from, 2 * n);
        return pack_rows(columns, std::span(o.slot).subspan(from, n), at + 8 * n + padded(2 * n));
    }

    std::vector<std::vector<std::byte>> exchange_rest() {
        const std::vector<ColumnBytes> columns = patch_.particles.columns();
        std::vector<std::vector<std::byte>> send(out_.size()), receive(in_.size());
        std::vector<Parcel> sends, receives;
        for (std::size_t k = 0; k < out_.size(); ++k) {
            const int rank = patch_.tables().peers[k].rank;
            const std::size_t n = outgoing_[k].slot.size();
            if (n > capacities_out_[k]) {
                send[k].resize(record_bytes(columns, n - capacities_out_[k]));
                pack(columns, outgoing_[k], capacities_out_[k], n, send[k].data());
                const auto bytes = static_cast<std::int64_t>(send[k].size());
                sends.push_back({rank, send[k].data(), bytes, bytes});
                bytes_ += bytes;
            }
            std::int64_t total = 0;
            std::memcpy(&total, in_[k].data(), 8);
            if (static_cast<std::size_t>(total) > capacities_in_[k]) {
                receive[k].resize(record_bytes(columns, static_cast<std::size_t>(total) - capacities_in_[k]));
                receives.push_back({rank, receive[k].data(), 0, static_cast<std::int64_t>(receive[k].size())});
            }
        }
        messages_.start(sends, receives);
        messages_.finish();
        return receive;
    }

    void unpack(std::size_t n, const std::byte* from, std::vector<OutgoingParticle>& outgoing,
                std::vector<std::uint32_t>& first) {
        const EpochTables<Dim>& tables = patch_.tables();
        const std::vector<std::uint32_t> slots = patch_.take_slots(n);
        unpack_rows(patch_.particles.columns(), slots, from + 8 * n + padded(2 * n));
        for (std::size_t k = 0; k < n; ++k) {
            std::uint64_t key = 0;
            std::uint16_t move = 0;
            std::memcpy(&key, from + 8 * k, 8);
            std::memcpy(&move, from + 8 * n + 2 * k, 2);
            outgoing.push_back({slots[k], move});
            ++first[ghost_of(tables, key) + 1];
        }
    }

    static std::size_t ghost_of(const EpochTables<Dim>& tables, Key key) {
        for (const PeerHalo& peer : tables.peers) {
            const auto begin = tables.ghost.begin() + peer.ghost_begin;
            const auto end = tables.ghost.begin() + peer.ghost_end;
            const auto it = std::lower_bound(begin, end, key);
            if (it != end && *it == key) return static_cast<std::size_t>(it - tables.ghost.begin());
        }
        return 0;
    }

    Share& patch_;
    PointToPoint& messages_;
    std::vector<std::size_t> capacities_out_, capacities_in_;
    std::vector<std::vector<std::byte>> out_, in_;
    std::vector<Outgoing> outgoing_;
    std::vector<std::uint32_t> gone_;
    std::vector<Parcel> sends_, receives_;
    std::int64_t crossed_ = 0;
    std::int64_t bytes_ = 0;
};

}  // namespace moraine
