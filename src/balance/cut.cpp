#include "balance/cut.hpp"

#include <algorithm>

namespace moraine {
namespace {

/// Prefix sums of a chain: the weight of [i, j) is sums[j] - sums[i].
class Chain {
  public:
    explicit Chain(std::span<const std::int64_t> weights) : sums_(weights.size() + 1, 0) {
        for (std::size_t i = 0; i < weights.size(); ++i) {
            sums_[i + 1] = sums_[i] + weights[i];
            heaviest_ = std::max(heaviest_, weights[i]);
        }
    }
    std::int64_t size() const { return static_cast<std::int64_t>(sums_.size()) - 1; }
    std::int64_t total() const { return sums_.back(); }
    std::int64_t heaviest() const { return heaviest_; }

    /// The last end of a part that begins at i and weighs at most b.
    std::int64_t end_of_part(std::int64_t i, std::int64_t b) const {
        const std::int64_t sum = sums_[i];
        const std::int64_t limit = b > total() - sum ? total() : sum + b;
        return std::upper_bound(sums_.begin() + i, sums_.end(), limit) - sums_.begin() - 1;
    }

    /// The first begin of a part that ends at j and weighs at most b.
    std::int64_t begin_of_part(std::int64_t j, std::int64_t b) const {
        return std::lower_bound(sums_.begin(), sums_.begin() + j, sums_[j] - b) - sums_.begin();
    }

    /// The position in [low, high] whose sum is nearest to the mean of `parts` equal parts of [i, size).
    std::int64_t nearest_to_mean(std::int64_t i, std::int64_t parts, std::int64_t low, std::int64_t high) const {
        const std::int64_t target = sums_[i] + (total() - sums_[i]) / parts;
        const std::int64_t k = std::lower_bound(sums_.begin() + low, sums_.begin() + high, target) - sums_.begin();
        return k > low && target - sums_[k - 1] < sums_[k] - target ? k - 1 : k;
    }

    bool fits(std::int64_t parts, std::int64_t b) const {
        std::int64_t i = 0;
        for (std::int64_t p = 0; p < parts && i < size(); ++p) i = end_of_part(i, b);
        return i == size();
    }

    /// The smallest weight of the heaviest of `parts` parts.
    std::int64_t bottleneck(std::int64_t parts) const {
        const std::int64_t mean = total() / parts + (total() % parts != 0);
        std::int64_t low = std::max(mean, heaviest_);                                 // nothing below fits
        std::int64_t high = heaviest_ > total() - mean ? total() : mean + heaviest_;  // always fits
        while (low < high) {
            const std::int64_t middle = low + (high - low) / 2;
            if (fits(parts, middle))
                high = middle;
            else
                low = middle + 1;
        }
        return low;
    }

  private:
    std::vector<std::int64_t> sums_;
    std::int64_t heaviest_ = 0;
};

/// Same number of blocks, to one, in each of the first `used` parts.
std::vector<std::int64_t> counted_cut(std::int64_t blocks, std::int64_t used, int parts) {
    std::vector<std::int64_t> cuts(static_cast<std::size_t>(parts) + 1, blocks);
    for (std::int64_t p = 0; p < used; ++p) cuts[p] = blocks / used * p + std::min(p, blocks % used);
    return cuts;
}

}  // namespace

std::vector<std::int64_t> exact_cut(std::span<const std::int64_t> weights, int parts) {
    const Chain chain(weights);
    const std::int64_t n = chain.size();
    const std::int64_t used = std::min<std::int64_t>(n, parts);
    if (chain.total() == 0 || used == n) return counted_cut(n, used, parts);

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
