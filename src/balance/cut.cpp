#include "balance/cut.hpp"

#include <algorithm>
#include <cmath>

namespace moraine {
namespace {

/// Same number of blocks, to one, in each of the first `used` parts.
std::vector<std::int64_t> counted_cut(std::int64_t blocks, std::int64_t used, int parts) {
    std::vector<std::int64_t> cuts(static_cast<std::size_t>(parts) + 1, blocks);
    for (std::int64_t p = 0; p < used; ++p) cuts[p] = blocks / used * p + std::min(p, blocks % used);
    return cuts;
}

/// All of the chain must fit into so many parts, and some link weigh something.
std::vector<std::int64_t> cut_of(const Chain& chain, int parts) {
    const std::int64_t n = chain.size();
    const std::int64_t used = std::min<std::int64_t>(n, parts);
    if (used == n) return counted_cut(n, used, parts);

    const std::int64_t b = chain.bottleneck(used);
    // first[p]: the blocks from there on, and from no earlier block, fit into the parts p, ..., used - 1
    std::vector<std::int64_t> first(static_cast<std::size_t>(used) + 1, n);
    for (std::int64_t p = used - 1; p > 0; --p) first[p] = chain.begin_of_part(first[p + 1], b);

    std::vector<std::int64_t> cuts(static_cast<std::size_t>(parts) + 1, n);
    cuts[0] = 0;
    for (std::int64_t p = 1; p < used; ++p) {
        const std::int64_t low = std::max(first[p], cuts[p - 1] + 1);
        const std::int64_t high = std::min(chain.end_of_part(cuts[p - 1], b), n - (used - p));
        cuts[p] = chain.nearest_to_mean(cuts[p - 1], used - p + 1, low, high);
    }
    return cuts;
}

}  // namespace

std::vector<std::int64_t> exact_cut(std::span<const std::int64_t> weights, int parts) {
    const Chain chain(weights);
    if (chain.total() == 0) return counted_cut(chain.size(), std::min<std::int64_t>(chain.size(), parts), parts);
    return cut_of(chain, parts);
}

std::optional<std::vector<std::int64_t>> exact_cut(std::span<const std::int64_t> weights, int parts,
                                                   const MemoryLimit& memory) {
    Chain chain(weights, memory);
    if (chain.total() == 0) chain = Chain(std::vector<std::int64_t>(weights.size(), 1), memory);
    if (!chain.fits(parts, chain.total())) return {};
    return cut_of(chain, parts);
}

std::int64_t even_parts(std::span<const std::int64_t> weights, std::int64_t at_most, double limit) {
    const Chain chain(weights);
    const double allowed = limit * static_cast<double>(chain.total());
    const auto is_even = [&](std::int64_t parts) {
        const double each = std::floor(allowed / static_cast<double>(parts));
        const bool takes_all = each >= static_cast<double>(chain.total());
        return takes_all || chain.fits(parts, static_cast<std::int64_t>(each));
    };
    std::int64_t low = 1, high = at_most;
    while (low < high) {
        const std::int64_t middle = low + (high - low + 1) / 2;
        if (is_even(middle))
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

std::int64_t heaviest_part(std::span<const std::int64_t> weights, std::span<const std::int64_t> cuts) {
    std::int64_t heaviest = 0;
    for (std::size_t p = 0; p + 1 < cuts.size(); ++p) {
        std::int64_t sum = 0;
        for (std::int64_t i = cuts[p]; i < cuts[p + 1]; ++i) sum += weights[i];
        heaviest = std::max(heaviest, sum);
    }
    return heaviest;
}

}  // namespace moraine
