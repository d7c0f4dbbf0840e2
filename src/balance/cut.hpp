#pragma once
// The exact cut of a chain of blocks into contiguous parts: the heaviest part is as light as it can be.
//
// The smallest feasible bottleneck B is found by bisection over integers; a probe fills parts from the
// left and costs O(P log N) on prefix sums (Pinar and Aykanat 2004, doi 10.1016/j.jpdc.2004.05.003).
// Among the cuts whose parts are all <= B, each cut point in turn, from the left, is the one nearest to
// the mean of what remains (rounded down; the later one on a tie) that still lets the rest fit into B. With
// at least as many blocks as parts no part is empty; with fewer, the first parts get one block each.
//
// Not the prefix cut (a block goes where p * total / P falls): it can exceed the optimum by a block.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace moraine {

/// A chain of weights by its prefix sums: what contiguous parts of a curve weigh, and where they end. A part is [i, j)
/// and weighs sums[j] - sums[i]; with weights that are not negative the sums rise, so a question about ends is a
/// binary search.
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
    std::int64_t weight(std::int64_t i, std::int64_t j) const { return sums_[j] - sums_[i]; }

    /// The last end of a part that begins at i and weighs at most b; i itself if link i alone is too heavy.
    std::int64_t end_of_part(std::int64_t i, std::int64_t b) const {
        const std::int64_t sum = sums_[i];
        const std::int64_t limit = b > total() - sum ? total() : sum + b;
        std::int64_t low = i, length = 1;  // by strides that double: most parts are short beside the chain
        while (low + length <= size() && sums_[low + length] <= limit) low += length, length *= 2;
        const std::int64_t high = std::min(low + length, size() + 1);
        return std::upper_bound(sums_.begin() + low, sums_.begin() + high, limit) - sums_.begin() - 1;
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

    /// The smallest weight of the heaviest of `parts` parts (bisection over integers).
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

    /// Do so many parts of at most b hold all?
    bool fits(std::int64_t parts, std::int64_t b) const {
        std::int64_t i = 0;
        for (std::int64_t p = 0; p < parts && i < size(); ++p) i = end_of_part(i, b);
        return i == size();
    }

  private:
    std::vector<std::int64_t> sums_;
    std::int64_t heaviest_ = 0;
};

/// parts + 1 first positions: part p is [cuts[p], cuts[p + 1]). Weights not negative, their total below
/// 2^63, parts >= 1. If all weights are zero the blocks are counted instead. Not collective.
std::vector<std::int64_t> exact_cut(std::span<const std::int64_t> weights, int parts);

/// The number of parts, of 1 to `at_most`, whose heaviest weighs at most `limit` times their mean while one more part
/// would be too many; of several such numbers bisection takes one. Weights as above, at_most >= 1, limit >= 1. Not
/// collective.
std::int64_t even_parts(std::span<const std::int64_t> weights, std::int64_t at_most, double limit);

/// The weight of the heaviest part. Not collective.
std::int64_t heaviest_part(std::span<const std::int64_t> weights, std::span<const std::int64_t> cuts);

}  // namespace moraine
