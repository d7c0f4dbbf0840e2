#pragma once
// Lists made by several threads, in the order that one thread alone would give them.
//
// Each thread counts what its part of the items makes, the counts are summed, each writes at its place: the result
// does not depend on how many threads there are. Appending under a lock would need a sort afterwards.

#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace moraine {

/// Contiguous parts of n items, one per thread; few items are one part.
struct Parts {
    std::size_t items;
    std::size_t count;

    explicit Parts(std::size_t n)
        : items(n), count(std::clamp<std::size_t>(n / 128, 1, static_cast<std::size_t>(omp_get_max_threads()))) {}

    std::size_t begin(std::size_t part) const { return items * part / count; }
    std::size_t end(std::size_t part) const { return begin(part + 1); }
};

/// Item i makes count(i) entries. Calls resize(entries of all items), then, where there are any, fill(i, its first
/// entry). Not collective.
template <class Count, class Resize, class Fill>
void place_in_order(std::size_t n, const Count& count, const Resize& resize, const Fill& fill) {
    const Parts parts(n);
    std::vector<std::size_t> first(parts.count + 1, 0);
#pragma omp parallel for schedule(static) if (parts.count > 1)
    for (std::size_t p = 0; p < parts.count; ++p) {
        std::size_t sum = 0;
        for (std::size_t i = parts.begin(p); i < parts.end(p); ++i) sum += static_cast<std::size_t>(count(i));
        first[p + 1] = sum;
    }
    for (std::size_t p = 0; p < parts.count; ++p) first[p + 1] += first[p];
    resize(first.back());
#pragma omp parallel for schedule(static) if (parts.count > 1)
    for (std::size_t p = 0; p < parts.count; ++p) {
        std::size_t at = first[p];
        for (std::size_t i = parts.begin(p); i < parts.end(p); ++i) {
            const auto entries = static_cast<std::size_t>(count(i));
            if (entries > 0) fill(i, at);
            at += entries;
        }
    }
}

/// The items for which chosen(i) holds, ascending. Not collective.
template <class Index, class Chosen>
std::vector<Index> chosen_of(std::size_t n, const Chosen& chosen) {
    std::vector<Index> list;
    place_in_order(
        n, [&](std::size_t i) { return chosen(i) ? 1 : 0; }, [&](std::size_t size) { list.resize(size); },
        [&](std::size_t i, std::size_t at) { list[at] = static_cast<Index>(i); });
    return list;
}

/// Numbers of items by bin, ascending within each: bin b has item[first[b]] to item[first[b + 1] - 1].
struct Grouped {
    std::vector<std::size_t> item;
    std::vector<std::size_t> first;
};

/// bin_of(i) in [0, bins). Not collective.
template <class BinOf>
Grouped grouped_in_order(std::size_t n, std::size_t bins, const BinOf& bin_of) {
    const Parts parts(n);
    std::vector<std::vector<std::size_t>> place(parts.count);  // of each part's next item of a bin
#pragma omp parallel for schedule(static) if (parts.count > 1)
    for (std::size_t p = 0; p < parts.count; ++p) {
        place[p].assign(bins, 0);
        for (std::size_t i = parts.begin(p); i < parts.end(p); ++i) ++place[p][static_cast<std::size_t>(bin_of(i))];
    }
    Grouped groups{std::vector<std::size_t>(n), std::vector<std::size_t>(bins + 1, 0)};
    std::size_t sum = 0;
    for (std::size_t b = 0; b < bins; ++b) {
        for (std::vector<std::size_t>& of_part : place) {
            const std::size_t size = of_part[b];
            of_part[b] = sum;
            sum += size;
        }
        groups.first[b + 1] = sum;
    }
#pragma omp parallel for schedule(static) if (parts.count > 1)
    for (std::size_t p = 0; p < parts.count; ++p)
        for (std::size_t i = parts.begin(p); i < parts.end(p); ++i)
            groups.item[place[p][static_cast<std::size_t>(bin_of(i))]++] = i;
    return groups;
}

}  // namespace moraine
