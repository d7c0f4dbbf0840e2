#pragma once
// Block moves: whole blocks travel to their new owners when the partition changes.
//
// A block travels in list order with all columns, so its list is the same wherever it lands.

#include <cstring>

#include "comm/patch.hpp"
#include "comm/transport.hpp"
#include "core/rows.hpp"

namespace moraine {

struct BlockMoveCount {
    std::int64_t particles = 0;  ///< sent by this rank
    std::int64_t blocks = 0;
};

/// Sends the blocks of `mine` to the ranks owner[i] and returns what this rank has then, keys ascending.
/// Blocks of one key that come from several ranks are joined in rank order. Collective.
template <class Space, class Real, int Dim>
FiledBlocks move_blocks(const Comm& comm, Patch<Space, Real, Dim>& patch, const FiledBlocks& mine,
                        const std::vector<std::int32_t>& owner, BlockMoveCount& moved) {
    struct Piece {
        Key key;
        int from;
        std::vector<std::uint32_t> slot;
    };
    const auto ranks = static_cast<std::size_t>(comm.size());
    std::vector<Piece> pieces;
    std::vector<FiledBlocks> to(ranks);
    std::size_t at = 0;
    for (std::size_t b = 0; b < mine.key.size(); at += mine.count[b], ++b) {
        const auto first = mine.slot.begin() + static_cast<std::ptrdiff_t>(at);
        const auto last = first + static_cast<std::ptrdiff_t>(mine.count[b]);
        if (owner[b] == comm.rank()) {
            pieces.push_back({mine.key[b], comm.rank(), {first, last}});
            continue;
        }
        FiledBlocks& leaving = to[static_cast<std::size_t>(owner[b])];
        leaving.key.push_back(mine.key[b]);
        leaving.count.push_back(mine.count[b]);
        leaving.slot.insert(leaving.slot.end(), first, last);
        moved.particles += mine.count[b];
        ++moved.blocks;
    }

    std::vector<ColumnBytes> columns = patch.particles.columns();
    std::vector<std::vector<std::byte>> bytes(ranks);
    for (std::size_t r = 0; r < ranks; ++r) {
        const std::size_t n = to[r].key.size();
        if (n == 0) continue;
        bytes[r].resize(8 + 8 * n + padded(4 * n) + rows_bytes(columns, to[r].slot.size()));
        const auto blocks = static_cast<std::int64_t>(n);
        std::memcpy(bytes[r].data(), &blocks, 8);
        std::memcpy(bytes[r].data() + 8, to[r].key.data(), 8 * n);
        std::memcpy(bytes[r].data() + 8 + 8 * n, to[r].count.data(), 4 * n);
        gather_rows(columns, to[r].slot, bytes[r].data() + 8 + 8 * n + padded(4 * n));
    }
    for (const FiledBlocks& leaving : to) patch.give_slots(leaving.slot);
    const std::vector<std::vector<std::byte>> come = exchange_all(comm, bytes);
    for (std::size_t r = 0; r < ranks; ++r) {
        if (come[r].empty()) continue;
        std::int64_t blocks = 0;
        std::memcpy(&blocks, come[r].data(), 8);
        const auto n = static_cast<std::size_t>(blocks);
        std::vector<Key> key(n);
        std::vector<std::uint32_t> count(n);
        std::memcpy(key.data(), come[r].data() + 8, 8 * n);
        std::memcpy(count.data(), come[r].data() + 8 + 8 * n, 4 * n);
        std::size_t rows = 0;
        for (std::uint32_t c : count) rows += c;
        const std::vector<std::uint32_t> slots = patch.take_slots(rows);
        columns = patch.particles.columns();
        scatter_rows(columns, slots, come[r].data() + 8 + 8 * n + padded(4 * n));
        auto first = slots.begin();
        for (std::size_t b = 0; b < n; ++b) {
            const auto last = first + static_cast<std::ptrdiff_t>(count[b]);
            pieces.push_back({key[b], static_cast<int>(r), {first, last}});
            first = last;
        }
    }

    std::sort(pieces.begin(), pieces.end(),
              [](const Piece& a, const Piece& b) { return a.key != b.key ? a.key < b.key : a.from < b.from; });
    FiledBlocks result;
    for (const Piece& piece : pieces) {
        if (result.key.empty() || result.key.back() != piece.key) {
            result.key.push_back(piece.key);
            result.count.push_back(0);
        }
        result.count.back() += static_cast<std::uint32_t>(piece.slot.size());
        result.slot.insert(result.slot.end(), piece.slot.begin(), piece.slot.end());
    }
    return result;
}

}  // namespace moraine
