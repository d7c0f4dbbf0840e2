#pragma once
// Particles for tests of files: what a row holds depends on its id alone, so any rank can check any row.
// Blocks have irregular keys and counts (some empty) and belong to pseudo-random ranks.

#include <cstdint>
#include <vector>

#include "io/columns.hpp"

namespace sample {

inline std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}

inline double number(std::uint64_t id, int what) {
    return static_cast<double>(mix(id * 16 + static_cast<std::uint64_t>(what)) >> 11) * 0x1p-53;
}

/// The whole table of blocks; ids of particles count up along it.
inline std::vector<moraine::BlockRow> blocks(int count, std::int64_t rows_per_block) {
    std::vector<moraine::BlockRow> all;
    moraine::Key key = 5;
    for (int b = 0; b < count; ++b) {
        key += 1 + mix(static_cast<std::uint64_t>(b)) % 1000;
        const auto rows = static_cast<std::int64_t>(mix(key) % static_cast<std::uint64_t>(2 * rows_per_block + 1));
        all.push_back({key, b % 7 == 3 ? 0 : rows});
    }
    return all;
}

/// What one rank has of it.
struct Part {
    std::vector<moraine::BlockRow> blocks;
    std::vector<moraine::RowRange> ranges;
    std::vector<std::uint64_t> id;
    std::vector<double> position;  ///< two numbers a row
    std::vector<float> stress;     ///< six numbers a row

    Part(const std::vector<moraine::BlockRow>& all, int rank, int ranks, std::uint64_t seed) {
        std::int64_t start = 0;
        for (const auto& block : all) {
            const bool mine = static_cast<int>(mix(block.key ^ seed) % static_cast<std::uint64_t>(ranks)) == rank;
            if (mine) add(block, start);
            start += block.count;
        }
    }

    std::vector<moraine::Column> columns() const {
        using moraine::Column;
        return {Column::of("id", "-", id.data()), Column::of("position", "m", position.data(), 2),
                Column::of("stress", "Pa", stress.data(), 6)};
    }

  private:
    void add(const moraine::BlockRow& block, std::int64_t start) {
        blocks.push_back(block);
        ranges.push_back({start, block.count});
        for (std::int64_t row = start; row < start + block.count; ++row) {
            const auto i = static_cast<std::uint64_t>(row);
            id.push_back(i);
            for (int c = 0; c < 2; ++c) position.push_back(number(i, c));
            for (int c = 0; c < 6; ++c) stress.push_back(static_cast<float>(number(i, 2 + c)));
        }
    }
};

}  // namespace sample
