#include "balance/least_migration.hpp"

#include <algorithm>
#include <array>

#include "balance/cut.hpp"

namespace moraine {
namespace {

constexpr std::int64_t most_states = std::int64_t(1) << 23;

/// Particles that stay, and where the last part begins: 2 link, + 1 if the home there was not taken before.
struct Choice {
    std::int64_t kept = -1;
    std::int64_t from = -1;

    bool possible() const { return from >= 0; }
    void improve(const Choice& other, std::int64_t more = 0) {
        if (other.possible() && (!possible() || other.kept + more > kept)) *this = {other.kept + more, other.from};
    }
};

/// The best of a window whose ends only move right.
class SlidingBest {
  public:
    void clear() { queue_.clear(), head_ = 0; }
    void push(std::int64_t link, const Choice& choice) {
        if (!choice.possible()) return;
        while (queue_.size() > head_ && queue_.back().choice.kept <= choice.kept) queue_.pop_back();
        queue_.push_back({link, choice});
    }
    Choice from(std::int64_t link) {
        while (head_ < queue_.size() && queue_[head_].link < link) ++head_;
        return head_ < queue_.size() ? queue_[head_].choice : Choice{};
    }

  private:
    struct Entry {
        std::int64_t link;
        Choice choice;
    };
    std::vector<Entry> queue_;
    std::size_t head_ = 0;
};

/// The states of one number of parts: links covered from `first` on.
struct Layer {
    std::int64_t first = 0;
    std::vector<Choice> any, fresh;  ///< fresh: the home of the next link has not been taken

    std::int64_t last() const { return first + static_cast<std::int64_t>(any.size()) - 1; }
};

class Search {
  public:
    Search(std::span<const std::int64_t> weights, const OwnerAffinity& homes, int parts, double tolerance,
           const MemoryLimit& memory)
        : chain_(weights, memory), held_(homes.held), homes_(homes), parts_(parts), home_of_(weights.size()) {
        const std::int64_t best = chain_.bottleneck(std::min<std::int64_t>(parts, chain_.size()));
        const double allowed = tolerance * static_cast<double>(best);
        limit_ = allowed < static_cast<double>(chain_.total() - best) ? best + static_cast<std::int64_t>(allowed)
                                                                      : chain_.total();
        for (std::size_t h = 0; h < homes.rank.size(); ++h)
            std::fill(home_of_.begin() + homes.first[h], home_of_.begin() + homes.first[h + 1],
                      static_cast<std::int32_t>(h));
        begin_.reserve(weights.size() + 1);
        for (std::int64_t i = 0, j = 0; j <= chain_.size(); begin_.push_back(i), ++j)
            while (!chain_.is_part(i, j, limit_)) ++i;
        set_ranges();
    }

    bool is_too_much() const { return states_ > most_states; }

    RankedCut best() {
        Layer now;
        now.any = now.fresh = {{0, 0}};
        Choice end;
        int used = 0;
        for (int k = 1; k <= parts_; ++k) {
            now = next(now, k);
            remember(now);
            if (now.last() == chain_.size() && now.any.back().possible() && now.any.back().kept >= end.kept)
                end = now.any.back(), used = k;
        }
        return trace(used);
    }

  private:
    /// Of k parts: at least so many links that the rest fits into the others, at most what k parts hold.
    void set_ranges() {
        low_.assign(static_cast<std::size_t>(parts_) + 1, chain_.size());
        high_.assign(static_cast<std::size_t>(parts_) + 1, 0);
        for (int k = parts_ - 1; k >= 0; --k) low_[k] = begin_[low_[k + 1]];
        for (int k = 1; k <= parts_; ++k) high_[k] = chain_.end_of_part(high_[k - 1], limit_);
        for (int k = 1; k <= parts_; ++k) states_ += high_[k] - low_[k] + 1;
    }

    Layer next(const Layer& now, int k) {
        Layer layer;
        layer.first = low_[k];
        layer.any.resize(static_cast<std::size_t>(high_[k] - low_[k] + 1));
        layer.fresh.resize(layer.any.size());
        if (high_[k] == 0) return layer;
        for (std::int32_t h = home_of_[std::max<std::int64_t>(low_[k] - 1, 0)]; h <= home_of_[high_[k] - 1]; ++h)
            end_in_home(now, layer, h);
        return layer;
    }

    /// The parts that end inside home h or at its end.
    void end_in_home(const Layer& now, Layer& layer, std::int32_t h) {
        const std::int64_t begin = homes_.first[h];
        const std::int64_t end = homes_.first[h + 1];
        const std::int64_t first = std::max(begin + 1, layer.first);
        const std::int64_t last = std::min(end, layer.last());
        if (first > last) return;
        look_left(now, h, begin_[first]);
        plain_.clear(), fresh_.clear(), taken_.clear();
        std::int64_t seen = std::max(begin, begin_[first]);
        for (std::int64_t j = first; j <= last; ++j) {
            for (; seen < j && seen <= now.last(); ++seen) see_inside(now, seen);
            Choice& any = layer.any[j - layer.first];
            Choice& fresh = layer.fresh[j - layer.first];
            fresh.improve(fresh_.from(begin_[j]));
            any.improve(plain_.from(begin_[j]));
            any.improve(taken_.from(begin_[j]), held_.weight(0, j));
            if (const std::int64_t at = begin_[j] - begin_[first]; at < static_cast<std::int64_t>(left_.size())) {
                const Left& left = left_[at];
                fresh.improve(left.passed);
                any.improve(left.passed);
                any.improve(left.plain, held_.weight(begin, j));
            }
            if (j == end) fresh = any;
        }
    }

    /// A part that begins at i, in the home in which it will end.
    void see_inside(const Layer& now, std::int64_t i) {
        const Choice& any = now.any[i - now.first];
        const Choice& fresh = now.fresh[i - now.first];
        if (any.possible()) plain_.push(i, {any.kept, 2 * i});
        if (!fresh.possible()) return;
        fresh_.push(i, {fresh.kept, 2 * i + 1});
        taken_.push(i, {fresh.kept - held_.weight(0, i), 2 * i + 1});
    }

    /// Parts that begin left of home h, from link `leftmost` on: the best of those that begin at a link or after it.
    void look_left(const Layer& now, std::int32_t h, std::int64_t leftmost) {
        const std::int64_t right = std::min(homes_.first[h] - 1, now.last());
        left_.assign(static_cast<std::size_t>(std::max<std::int64_t>(right - leftmost + 1, 0)), Left{});
        std::int64_t largest = 0;  // of the homes wholly between the link and home h
        std::int32_t between = h;
        for (std::int64_t i = right; i >= leftmost; --i) {
            for (; between > 0 && homes_.first[between - 1] >= i; --between)
                largest = std::max(largest, held_.weight(homes_.first[between - 1], homes_.first[between]));
            Left& left = left_[i - leftmost];
            if (i < right) left = left_[i + 1 - leftmost];
            const Choice& any = now.any[i - now.first];
            const Choice& fresh = now.fresh[i - now.first];
            if (any.possible()) left.plain.improve({any.kept, 2 * i});
            if (any.possible()) left.passed.improve({any.kept + largest, 2 * i});
            if (fresh.possible())
                left.passed.improve({fresh.kept + held_.weight(i, homes_.first[home_of_[i] + 1]), 2 * i + 1});
        }
    }

    void remember(const Layer& layer) {
        std::vector<std::array<std::int32_t, 2>>& from = from_.emplace_back();
        from.reserve(layer.any.size());
        for (std::size_t i = 0; i < layer.any.size(); ++i)
            from.push_back(
                {static_cast<std::int32_t>(layer.any[i].from), static_cast<std::int32_t>(layer.fresh[i].from)});
    }

    /// Back from the end, part by part.
    RankedCut trace(int used) const {
        RankedCut result;
        result.cuts.assign(static_cast<std::size_t>(parts_) + 1, chain_.size());
        result.rank_of.assign(static_cast<std::size_t>(parts_), -1);
        std::int64_t j = chain_.size();
        bool is_fresh = false;
        for (int k = used; k > 0; --k) {
            const std::int32_t from = from_[k - 1][j - low_[k]][is_fresh];
            const std::int64_t i = from / 2;
            result.cuts[k - 1] = i;
            result.rank_of[k - 1] = taken_home(i, j, from % 2 != 0, is_fresh);
            j = i;
            is_fresh = from % 2 != 0;
        }
        return result;
    }

    /// The rank that the part [i, j) keeps most of, among the homes that it may take.
    std::int32_t taken_home(std::int64_t i, std::int64_t j, bool fresh_before, bool fresh_after) const {
        std::int32_t rank = -1;
        std::int64_t most = 0;
        for (std::int32_t h = home_of_[i]; h <= home_of_[j - 1]; ++h) {
            const std::int64_t begin = homes_.first[h];
            const std::int64_t end = homes_.first[h + 1];
            if ((begin < i && !fresh_before) || (end > j && fresh_after)) continue;
            const std::int64_t kept = held_.weight(std::max(i, begin), std::min(j, end));
            if (kept > most) most = kept, rank = homes_.rank[h];
        }
        return rank;
    }

    struct Left {
        Choice plain;   ///< keeps nothing yet
        Choice passed;  ///< keeps the best of what lies left of the home
    };

    Chain chain_, held_;
    const OwnerAffinity& homes_;
    int parts_;
    std::int64_t limit_ = 0;
    std::int64_t states_ = 0;
    std::vector<std::int32_t> home_of_;                           // of each link
    std::vector<std::int64_t> begin_;                             // of the longest part that ends at a link
    std::vector<std::int64_t> low_, high_;                        // links covered by k parts
    std::vector<std::vector<std::array<std::int32_t, 2>>> from_;  // of each layer: for any and for fresh
    SlidingBest plain_, fresh_, taken_;
    std::vector<Left> left_;  // of the links left of a home
};

}  // namespace

std::optional<RankedCut> least_migration(std::span<const std::int64_t> weights, const OwnerAffinity& homes, int parts,
                                         double tolerance, const MemoryLimit& memory) {
    const bool weighs = std::any_of(weights.begin(), weights.end(), [](std::int64_t w) { return w > 0; });
    if (homes.rank.empty() || !weighs) return {};
    Search search(weights, homes, parts, tolerance, memory);
    if (search.is_too_much()) return {};
    return search.best();
}

}  // namespace moraine
