#include "balance/owner_affinity.hpp"

#include <algorithm>
#include <tuple>

namespace moraine {
namespace {

/// Blocks by link (counting sort), those alone that a rank holds.
class LinkedBlocks {
  public:
    LinkedBlocks(std::span<const BlockLoad> blocks, std::span<const std::int32_t> link_of, std::int64_t links,
                 int ranks)
        : blocks_(blocks), first_(static_cast<std::size_t>(links) + 1, 0) {
        const auto is_held = [&](std::size_t b) {
            return blocks[b].owner >= 0 && blocks[b].owner < ranks && blocks[b].particles > 0;
        };
        for (std::size_t b = 0; b < blocks.size(); ++b)
            if (is_held(b)) ++first_[link_of[b] + 1];
        for (std::size_t l = 1; l < first_.size(); ++l) first_[l] += first_[l - 1];
        order_.resize(static_cast<std::size_t>(first_.back()));
        std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
        for (std::size_t b = 0; b < blocks.size(); ++b)
            if (is_held(b)) order_[next[link_of[b]]++] = static_cast<std::int32_t>(b);
    }

    template <class F>
    void each(std::int64_t link, const F& f) const {
        for (std::int64_t k = first_[link]; k < first_[link + 1]; ++k) f(blocks_[order_[k]]);
    }

    std::int64_t held_by(std::int32_t rank, std::int64_t link) const {
        std::int64_t sum = 0;
        each(link, [&](const BlockLoad& block) { sum += block.owner == rank ? block.particles : 0; });
        return sum;
    }

  private:
    std::span<const BlockLoad> blocks_;
    std::vector<std::int64_t> first_;
    std::vector<std::int32_t> order_;
};

struct Median {
    std::int64_t median;  ///< link at which the rank has half of its particles behind it
    std::int32_t rank;
};

std::vector<Median> medians_of(const LinkedBlocks& linked, std::int64_t links, int ranks) {
    std::vector<std::int64_t> total(static_cast<std::size_t>(ranks), 0);
    for (std::int64_t l = 0; l < links; ++l)
        linked.each(l, [&](const BlockLoad& block) { total[block.owner] += block.particles; });
    std::vector<std::int64_t> behind(static_cast<std::size_t>(ranks), 0);
    std::vector<Median> medians;
    for (std::int64_t l = 0; l < links; ++l)
        linked.each(l, [&](const BlockLoad& block) {
            const std::int64_t half = (total[block.owner] + 1) / 2;
            std::int64_t& sum = behind[block.owner];
            if (sum < half && sum + block.particles >= half) medians.push_back({l, block.owner});
            sum += block.particles;
        });
    std::sort(medians.begin(), medians.end(),
              [](const Median& x, const Median& y) { return std::tie(x.median, x.rank) < std::tie(y.median, y.rank); });
    return medians;
}

/// The first link of the right one of two neighbours: most particles at home on both sides.
std::int64_t border(const LinkedBlocks& linked, const Median& left, const Median& right) {
    std::int64_t best = left.median + 1;
    std::int64_t gain = 0;
    std::int64_t most = 0;
    for (std::int64_t l = left.median + 1; l < right.median; ++l) {
        gain += linked.held_by(left.rank, l) - linked.held_by(right.rank, l);
        if (gain > most) most = gain, best = l + 1;
    }
    return best;
}

}  // namespace

OwnerAffinity affinity_of(std::span<const BlockLoad> blocks, std::span<const std::int32_t> link_of, std::int64_t links,
                          int ranks) {
    const LinkedBlocks linked(blocks, link_of, links, ranks);
    const std::vector<Median> medians = medians_of(linked, links, ranks);
    OwnerAffinity affinity;
    affinity.held.assign(static_cast<std::size_t>(links), 0);
    std::int64_t first = 0;
    for (std::size_t s = 0; s < medians.size(); ++s) {
        const std::int64_t last = s + 1 < medians.size() ? border(linked, medians[s], medians[s + 1]) : links;
        if (last <= first) continue;
        affinity.rank.push_back(medians[s].rank);
        affinity.first.push_back(first);
        for (std::int64_t l = first; l < last; ++l) affinity.held[l] = linked.held_by(medians[s].rank, l);
        first = last;
    }
    affinity.first.push_back(links);
    return affinity;
}

}  // namespace moraine
