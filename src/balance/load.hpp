#pragma once
// What balancing looks at: the occupied blocks of all ranks, in sorted key order.
//
// Every rank holds the same list and derives the same owners from it, so no decision is ever sent.
// Loads are integers: sums, and therefore cuts, do not depend on the order of summation or on the
// number of ranks. Totals must stay below 2^63 (in nanoseconds: 292 years).
//
// Imbalance is the maximum over the mean of all ranks, idle ones included:
//
//   max/mean = max * ranks / total,   1 where there is no load at all
//
// A step lasts as long as its slowest rank, so 1 - mean/max of the ranks' time is lost. Leaving idle ranks out of the
// mean would make a partition that uses half of the machine look perfect.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "blocks/topology.hpp"
#include "core/data/morton.hpp"

namespace moraine {

struct BlockLoad {
    Key key;
    std::int64_t particles;
    std::int64_t weight;  ///< what the cut balances, not negative: particles, cost [ns], or time [ps]
    std::int32_t owner;   ///< rank that holds the block now; -1: nobody yet
};

/// The domain in blocks, of a scene of 2 or 3 dimensions.
struct Layout {
    int dimensions = 3;
    std::array<std::int32_t, 3> blocks{1, 1, 1};  ///< per axis; 1 where the scene has no axis
    std::array<bool, 3> periodic{};               ///< axes that close on themselves
    int width = 3;                                ///< of the stencil, in nodes per axis
};

/// width: of the stencil. Not collective.
template <int Dim>
Layout layout_of(const DomainBlocks<Dim>& domain, int width) {
    Layout layout;
    layout.dimensions = Dim;
    layout.width = width;
    std::copy(domain.periodic.begin(), domain.periodic.end(), layout.periodic.begin());
    std::copy(domain.count.begin(), domain.count.end(), layout.blocks.begin());
    return layout;
}

using Position = std::array<std::int32_t, 3>;  ///< of a block, from the domain's lower corner; 0 where no axis

/// Not collective.
inline Position block_position(const Layout& layout, Key key) {
    if (layout.dimensions == 2) {
        const BlockPosition<2> p = Morton<2>::decode(key);
        return {p[0], p[1], 0};
    }
    return Morton<3>::decode(key);
}

/// Sum of one column of the loads for each of `ranks` ranks, if block b belonged to owners[b];
/// blocks without an owner (-1) count for nobody. Not collective.
std::vector<std::int64_t> loads_of_ranks(std::span<const BlockLoad> blocks, std::span<const std::int32_t> owners,
                                         int ranks, std::int64_t BlockLoad::*column = &BlockLoad::weight);

/// The owners that the blocks have now. Not collective.
std::vector<std::int32_t> present_owners(std::span<const BlockLoad> blocks);

/// Kept as integers, so that partitions can be compared exactly.
struct LoadSummary {
    std::int64_t max = 0;
    std::int64_t total = 0;
    int ranks = 1;

    double imbalance() const {
        return total == 0 ? 1.0 : static_cast<double>(max) * ranks / static_cast<double>(total);
    }
};

/// One load per rank. Not collective.
inline LoadSummary summary_of(std::span<const std::int64_t> loads) {
    LoadSummary s{0, 0, static_cast<int>(loads.size())};
    for (std::int64_t load : loads) s.max = std::max(s.max, load), s.total += load;
    return s;
}

}  // namespace moraine
