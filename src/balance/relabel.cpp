#include "balance/relabel.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace moraine {
namespace {

std::int64_t staying(const std::vector<Overlap>& pairs, const std::vector<std::int32_t>& rank_of) {
    std::int64_t sum = 0;
    for (const Overlap& o : pairs)
        if (rank_of[o.part] == o.rank) sum += o.particles;
    return sum;
}

/// Parts without a rank get their own number if it is free, then the free ranks in order.
void fill_up(std::vector<std::int32_t>& rank_of, std::vector<char>& taken) {
    const auto ranks = static_cast<std::int32_t>(rank_of.size());
    for (std::int32_t p = 0; p < ranks; ++p)
        if (rank_of[p] < 0 && !taken[p]) rank_of[p] = p, taken[p] = 1;
    std::int32_t next = 0;
    for (std::int32_t p = 0; p < ranks; ++p) {
        if (rank_of[p] >= 0) continue;
        while (taken[next]) ++next;
        rank_of[p] = next++;
    }
}

/// `pairs` with the most particles first; a part that has a rank keeps it.
std::vector<std::int32_t> greedy(const std::vector<Overlap>& pairs, std::vector<std::int32_t> rank_of) {
    std::vector<char> taken(rank_of.size(), 0);
    for (std::int32_t rank : rank_of)
        if (rank >= 0) taken[rank] = 1;
    for (const Overlap& o : pairs)
        if (rank_of[o.part] < 0 && !taken[o.rank]) rank_of[o.part] = o.rank, taken[o.rank] = 1;
    fill_up(rank_of, taken);
    return rank_of;
}

}  // namespace

std::vector<Overlap> overlaps(std::span<const BlockLoad> blocks, std::span<const std::int32_t> part_of, int ranks) {
    std::vector<Overlap> runs;  // neighbours in the list mostly share part and owner: merge before sorting
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        const std::int32_t rank = blocks[b].owner;
        if (rank < 0 || rank >= ranks) continue;
        if (!runs.empty() && runs.back().part == part_of[b] && runs.back().rank == rank)
            runs.back().particles += blocks[b].particles;
        else
            runs.push_back({part_of[b], rank, blocks[b].particles});
    }
    std::sort(runs.begin(), runs.end(),
              [](const Overlap& x, const Overlap& y) { return std::tie(x.part, x.rank) < std::tie(y.part, y.rank); });
    std::vector<Overlap> pairs;
    for (const Overlap& run : runs)
        if (!pairs.empty() && pairs.back().part == run.part && pairs.back().rank == run.rank)
            pairs.back().particles += run.particles;
        else
            pairs.push_back(run);
    return pairs;
}

std::vector<std::int32_t> relabel_pairs(std::vector<Overlap> pairs, int ranks, std::span<const std::int32_t> wanted) {
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Overlap& x, const Overlap& y) { return x.particles > y.particles; });
    std::vector<std::vector<std::int32_t>> ways;  // the first of the best is taken
    ways.push_back(greedy(pairs, std::vector<std::int32_t>(static_cast<std::size_t>(ranks), -1)));
    ways.emplace_back(static_cast<std::size_t>(ranks));
    std::iota(ways.back().begin(), ways.back().end(), 0);
    if (!wanted.empty()) ways.push_back(greedy(pairs, {wanted.begin(), wanted.end()}));
    std::size_t best = 0;
    for (std::size_t w = 1; w < ways.size(); ++w)
        if (staying(pairs, ways[w]) > staying(pairs, ways[best])) best = w;
    return ways[best];
}

std::vector<std::int32_t> relabel(std::span<const BlockLoad> blocks, std::span<const std::int32_t> part_of, int ranks,
                                  std::span<const std::int32_t> wanted) {
    return relabel_pairs(overlaps(blocks, part_of, ranks), ranks, wanted);
}

Moved moved(std::span<const BlockLoad> blocks, std::span<const std::int32_t> owners) {
    Moved m;
    for (std::size_t b = 0; b < blocks.size(); ++b)
        if (blocks[b].owner >= 0 && blocks[b].owner != owners[b]) m.particles += blocks[b].particles, ++m.blocks;
    return m;
}

}  // namespace moraine
