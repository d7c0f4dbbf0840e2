#include "comm/block_move.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "comm/point_to_point.hpp"
#include "core/data/host.hpp"
#include "core/particles/particle_bytes.hpp"

namespace moraine {
namespace {

/// A block's part that one rank held, in the slots where it is now.
struct MovedBlock {
    Key key;
    int from;  ///< rank
    std::vector<std::uint32_t> slot;
};

/// Blocks by the rank that they go to; those that stay become entries of `moved_blocks`. Not collective.
std::vector<BinnedBlocks> split_by_owner(const Comm& comm, const BinnedBlocks& mine,
                                         const std::vector<std::int32_t>& owner, std::vector<MovedBlock>& moved_blocks,
                                         BlockMoveCount& moved) {
    std::vector<BinnedBlocks> to(static_cast<std::size_t>(comm.size()));
    std::size_t at = 0;
    for (std::size_t b = 0; b < mine.key.size(); at += mine.count[b], ++b) {
        const auto first = mine.slot.begin() + static_cast<std::ptrdiff_t>(at);
        const auto last = first + static_cast<std::ptrdiff_t>(mine.count[b]);
        if (owner[b] == comm.rank()) {
            moved_blocks.push_back({mine.key[b], comm.rank(), {first, last}});
            continue;
        }
        BinnedBlocks& leaving = to[static_cast<std::size_t>(owner[b])];
        leaving.key.push_back(mine.key[b]);
        leaving.count.push_back(mine.count[b]);
        leaving.slot.insert(leaving.slot.end(), first, last);
        moved.particles += mine.count[b];
        ++moved.blocks;
    }
    return to;
}

/// A message of blocks: their number, keys, counts of particles, and the particles' rows. Empty where there are none.
std::vector<std::byte> packed_blocks(const std::vector<ColumnBytes>& columns, const BinnedBlocks& blocks) {
    const std::size_t n = blocks.key.size();
    if (n == 0) return {};
    const std::size_t keys = 8, counts = keys + 8 * n, rows = counts + padded(4 * n);
    std::vector<std::byte> bytes(rows + rows_bytes(columns, blocks.slot.size()));
    const auto number = static_cast<std::int64_t>(n);
    std::memcpy(bytes.data(), &number, 8);
    std::memcpy(bytes.data() + keys, blocks.key.data(), 8 * n);
    std::memcpy(bytes.data() + counts, blocks.count.data(), 4 * n);
    pack_rows(columns, blocks.slot, bytes.data() + rows);
    return bytes;
}

/// Takes the blocks of a message (packed_blocks) into free slots. Not collective.
template <class Space, class Real, int Dim>
void unpack_blocks(const std::vector<std::byte>& bytes, int from, Patch<Space, Real, Dim>& patch,
                   std::vector<MovedBlock>& moved_blocks) {
    if (bytes.empty()) return;
    std::int64_t number = 0;
    std::memcpy(&number, bytes.data(), 8);
    const auto n = static_cast<std::size_t>(number);
    const std::size_t keys = 8, counts = keys + 8 * n, rows = counts + padded(4 * n);
    std::vector<Key> key(n);
    std::vector<std::uint32_t> count(n);
    std::memcpy(key.data(), bytes.data() + keys, 8 * n);
    std::memcpy(count.data(), bytes.data() + counts, 4 * n);
    std::size_t particles = 0;
    for (std::uint32_t c : count) particles += c;
    const std::vector<std::uint32_t> slots = patch.take_slots(particles);
    unpack_rows(patch.particles.columns(), slots, bytes.data() + rows);
    auto first = slots.begin();
    for (std::size_t b = 0; b < n; ++b) {
        const auto last = first + static_cast<std::ptrdiff_t>(count[b]);
        moved_blocks.push_back({key[b], from, {first, last}});
        first = last;
    }
}

}  // namespace

template <class Space, class Real, int Dim>
BinnedBlocks move_blocks(const Comm& comm, Patch<Space, Real, Dim>& patch, const BinnedBlocks& mine,
                         const std::vector<std::int32_t>& owner, BlockMoveCount& moved) {
    std::vector<MovedBlock> blocks;
    const std::vector<BinnedBlocks> to = split_by_owner(comm, mine, owner, blocks, moved);
    const std::vector<ColumnBytes> columns = patch.particles.columns();
    std::vector<std::vector<std::byte>> bytes;
    for (const BinnedBlocks& leaving : to) bytes.push_back(packed_blocks(columns, leaving));
    for (const BinnedBlocks& leaving : to) patch.give_slots(leaving.slot);
    const std::vector<std::vector<std::byte>> come = exchange_all(comm, bytes);
    for (std::size_t r = 0; r < come.size(); ++r) unpack_blocks(come[r], static_cast<int>(r), patch, blocks);

    std::sort(blocks.begin(), blocks.end(), [](const MovedBlock& a, const MovedBlock& b) {
        return a.key != b.key ? a.key < b.key : a.from < b.from;
    });
    BinnedBlocks result;
    for (const MovedBlock& block : blocks) {
        if (result.key.empty() || result.key.back() != block.key) {
            result.key.push_back(block.key);
            result.count.push_back(0);
        }
        result.count.back() += static_cast<std::uint32_t>(block.slot.size());
        result.slot.insert(result.slot.end(), block.slot.begin(), block.slot.end());
    }
    return result;
}

template BinnedBlocks move_blocks(const Comm&, Patch<Host, float, 2>&, const BinnedBlocks&,
                                  const std::vector<std::int32_t>&, BlockMoveCount&);
template BinnedBlocks move_blocks(const Comm&, Patch<Host, float, 3>&, const BinnedBlocks&,
                                  const std::vector<std::int32_t>&, BlockMoveCount&);
template BinnedBlocks move_blocks(const Comm&, Patch<Host, double, 2>&, const BinnedBlocks&,
                                  const std::vector<std::int32_t>&, BlockMoveCount&);
template BinnedBlocks move_blocks(const Comm&, Patch<Host, double, 3>&, const BinnedBlocks&,
                                  const std::vector<std::int32_t>&, BlockMoveCount&);

}  // namespace moraine
