#pragma once
// The exact cut of a chain of blocks into contiguous parts: the heaviest part is as light as it can be.
//
// The smallest feasible bottleneck B is found by bisection over integers; a probe fills parts from the
// left and costs O(P log N) on prefix sums (Pinar and Aykanat 2004, doi 10.1016/j.jpdc.2004.05.003).
// Among the cuts whose parts are all <= B, each cut point in turn, from the left, is the one nearest to
// the mean of what remains (rounded down; the later one on a tie) that still lets the rest fit into B. With
// at least as many blocks as parts no part is empty; with fewer, the first parts get one block each.
//
// Memory is a second constraint: a part fits where it weighs at most B and holds at most what a rank has memory for. A
// piece of a part that fits does too, so the same probe, which takes as much as fits, is exact: if it needs more than P
// parts, every cut does.
//
// Not the prefix cut (a block goes where p * total / P falls): it can exceed the optimum by a block.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace moraine {

/// What parts may hold at most, besides their weight.
struct MemoryLimit {
    std::span<const std::int64_t> held;  ///< by each link, not negative; empty: there is no limit
    std::int64_t most = 0;               ///< by a part, not negative
};

/// A chain of weights by its prefix sums: what contiguous parts of a curve weigh, and where they end. A part is [i, j)
/// and weighs sums[j] - sums[i]; with weights that are not negative the sums rise, so a question about ends is a
/// binary search. A part fits into b if it weighs at most b, and holds no more than the limit of memory where one is.
class Chain {
  public:
    explicit Chain(std::span<const std::int64_t> weights, const MemoryLimit& memory = {})
        : sums_(sums_of(weights)), most_(memory.most) {
        for (const std::int64_t w : weights) heaviest_ = std::max(heaviest_, w);
        if (!memory.held.empty()) held_ = sums_of(memory.held);
    }

    std::int64_t size() const { return static_cast<std::int64_t>(sums_.size()) - 1; }
    std::int64_t total() const { return sums_.back(); }
    std::int64_t heaviest() const { return heaviest_; }
    std::int64_t weight(std::int64_t i, std::int64_t j) const { return sums_[j] - sums_[i]; }
    bool is_part(std::int64_t i, std::int64_t j, std::int64_t b) const {
        return weight(i, j) <= b && (held_.empty() || held_[j] - held_[i] <= most_);
    }

    /// The last end of a part that begins at i and fits into b; i itself if link i alone does not.
    std::int64_t end_of_part(std::int64_t i, std::int64_t b) const {
        const std::int64_t end = last_end(sums_, i, b);
        return held_.empty() ? end : std::min(end, last_end(held_, i, most_));
    }

    /// The first begin of a part that ends at j and fits into b.
    std::int64_t begin_of_part(std::int64_t j, std::int64_t b) const {
        const std::int64_t begin = first_begin(sums_, j, b);
        return held_.empty() ? begin : std::max(begin, first_begin(held_, j, most_));
    }

    /// The position in [low, high] whose sum is nearest to the mean of `parts` equal parts of [i, size).
    std::int64_t nearest_to_mean(std::int64_t i, std::int64_t parts, std::int64_t low, std::int64_t high) const {
        const std::int64_t target = sums_[i] + (total() - sums_[i]) / parts;
        const std::int64_t k = std::lower_bound(sums_.begin() + low, sums_.begin() + high, target) - sums_.begin();
        return k > low && target - sums_[k - 1] < sums_[k] - target ? k - 1 : k;
    }

    /// The smallest weight of the heaviest of `parts` parts (bisection over integers). So many parts must fit into the
    /// total.
    std::int64_t bottleneck(std::int64_t parts) const {
        const std::int64_t mean = total() / parts + (total() % parts != 0);
        const bool always = held_.empty() && heaviest_ <= total() - mean;
        std::int64_t low = std::max(mean, heaviest_);             // nothing below fits
        std::int64_t high = always ? mean + heaviest_ : total();  // always fits
        while (low < high) {
            const std::int64_t middle = low + (high - low) / 2;
            if (fits(parts, middle))
                high = middle;
            else
                low = middle + 1;
        }
        return low;
    }

    /// Do so many parts that fit into b hold all?
    bool fits(std::int64_t parts, std::int64_t b) const {
        std::int64_t i = 0;
        for (std::int64_t p = 0; p < parts && i < size(); ++p) i = end_of_part(i, b);
        return i == size();
    }

  private:
    using Sums = std::vector<std::int64_t>;

    static Sums sums_of(std::span<const std::int64_t> links) {
        Sums sums(links.size() + 1, 0);
        for (std::size_t i = 0; i < links.size(); ++i) sums[i + 1] = sums[i] + links[i];
        return sums;
    }

    static std::int64_t last_end(const Sums& sums, std::int64_t i, std::int64_t most) {
        const std::int64_t sum = sums[i], size = static_cast<std::int64_t>(sums.size()) - 1;
        const std::int64_t limit = most > sums.back() - sum ? sums.back() : sum + most;
        std::int64_t low = i, length = 1;  // by strides that double: most parts are short beside the chain
        while (low + length <= size && sums[low + length] <= limit) low += length, length *= 2;
        const std::int64_t high = std::min(low + length, size + 1);
        return std::upper_bound(sums.begin() + low, sums.begin() + high, limit) - sums.begin() - 1;
    }

    static std::int64_t first_begin(const Sums& sums, std::int64_t j, std::int64_t most) {
        return std::lower_bound(sums.begin(), sums.begin() + j, sums[j] - most) - sums.begin();
    }

    Sums sums_, held_;  ///< of weights, and of what links hold; none where memory has no limit
    std::int64_t most_ = 0, heaviest_ = 0;
};

/// parts + 1 first positions: part p is [cuts[p], cuts[p + 1]). Weights not negative, their total below
/// 2^63, parts >= 1. If all weights are zero the blocks are counted instead. Not collective.
std::vector<std::int64_t> exact_cut(std::span<const std::int64_t> weights, int parts);

/// The same under a limit of memory: exact_cut()'s rule among the cuts whose parts all keep to it, the heaviest part as
/// light as those allow. Nothing if no cut into so many parts does. Not collective.
std::optional<std::vector<std::int64_t>> exact_cut(std::span<const std::int64_t> weights, int parts,
                                                   const MemoryLimit& memory);

/// The number of parts, of 1 to `at_most`, whose heaviest weighs at most `limit` times their mean while one more part
/// would be too many; of several such numbers bisection takes one. Weights as above, at_most >= 1, limit >= 1. Not
/// collective.
std::int64_t even_parts(std::span<const std::int64_t> weights, std::int64_t at_most, double limit);

/// The weight of the heaviest part. Not collective.
std::int64_t heaviest_part(std::span<const std::int64_t> weights, std::span<const std::int64_t> cuts);

}  // namespace moraine
