#pragma once
// Rows of blocks, gathered from all ranks, in key order.

#include <algorithm>
#include <cstdint>
#include <vector>

namespace moraine {

/// rows: rank by rank, ascending keys in each; counts: of each rank. Most ranks hold one range of the curve: then
/// whole ranges are put in order, and no row is compared with those of others but at their ends. Not collective.
template <class Row>
std::vector<Row> in_key_order(const std::vector<Row>& rows, const std::vector<std::int64_t>& counts) {
    const auto before = [](const Row& a, const Row& b) { return a.key < b.key; };
    struct Range {
        const Row *first, *last;
    };
    std::vector<Range> ranges;
    const Row* next = rows.data();
    for (const std::int64_t count : counts) {
        if (count > 0) ranges.push_back({next, next + count});
        next += count;
    }
    std::sort(ranges.begin(), ranges.end(), [&](const Range& a, const Range& b) { return before(*a.first, *b.first); });
    std::vector<Row> ordered;
    ordered.reserve(rows.size());
    for (const Range& s : ranges) ordered.insert(ordered.end(), s.first, s.last);
    if (!std::is_sorted(ordered.begin(), ordered.end(), before)) std::sort(ordered.begin(), ordered.end(), before);
    return ordered;
}

}  // namespace moraine
