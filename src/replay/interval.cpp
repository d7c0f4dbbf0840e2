#include "replay/interval.hpp"

#include <algorithm>

#include "core/data/block.hpp"

namespace moraine {
namespace {

template <int Dim>
bool neighbour_in(const Layout& layout, Key key, int code, Key& result) {
    BlockPosition<Dim> at = Morton<Dim>::decode(key);
    for (int a = 0; a < Dim; ++a) {
        at[a] += Block<Dim>::offset(code, a);
        if (layout.periodic[a]) at[a] = (at[a] % layout.blocks[a] + layout.blocks[a]) % layout.blocks[a];
        if (at[a] < 0 || at[a] >= layout.blocks[a]) return false;
    }
    result = Morton<Dim>::encode(at);
    return true;
}

std::int64_t index_of(std::span<const BlockLoad> blocks, Key key) {
    const auto at =
        std::lower_bound(blocks.begin(), blocks.end(), key, [](const BlockLoad& load, Key k) { return load.key < k; });
    return at != blocks.end() && at->key == key ? at - blocks.begin() : -1;
}

/// Finds of each new block whom it follows, wave by wave from the blocks whose owners are known.
class Inheritance {
  public:
    Inheritance(const Layout& layout, std::span<const BlockLoad> now, Carry& carry)
        : layout_(layout), now_(now), carry_(carry), known_(now.size()), asked_(now.size(), 0) {
        for (std::size_t b = 0; b < now.size(); ++b) known_[b] = carry.from[b] >= 0;
    }

    void find(std::vector<std::int32_t> waiting) {
        std::vector<std::int32_t> wave = waiting;
        for (std::size_t first = 0; first < waiting.size();) {
            wave = pass(wave);
            while (first < waiting.size() && known_[waiting[first]]) ++first;
            if (!wave.empty() || first == waiting.size()) continue;
            const std::int32_t island = waiting[first];
            wave = follow({{island, std::max(island - 1, 0)}});
        }
    }

  private:
    using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

    template <class F>
    void each_neighbour(std::int32_t b, const F& f) const {
        Key near = 0;
        for (int code = 0; code < offsets_of(layout_); ++code) {
            if (!neighbour_key(layout_, now_[b].key, code, near)) continue;
            const std::int64_t i = index_of(now_, near);
            if (i >= 0 && f(static_cast<std::int32_t>(i))) return;
        }
    }

    /// Blocks of the wave beside a known one follow it; those that may follow them are the next wave.
    std::vector<std::int32_t> pass(const std::vector<std::int32_t>& wave) {
        Pairs found;
        for (const std::int32_t b : wave)
            each_neighbour(b, [&](std::int32_t near) {
                if (known_[near]) found.emplace_back(b, near);
                return known_[near] != 0;
            });
        return follow(found);
    }

    std::vector<std::int32_t> follow(const Pairs& found) {
        for (const auto& [b, near] : found) {
            known_[b] = 1;
            carry_.inheriting.emplace_back(b, near);
        }
        ++number_;
        std::vector<std::int32_t> next;
        for (const auto& pair : found)
            each_neighbour(pair.first, [&](std::int32_t near) {
                if (!known_[near] && asked_[near] != number_) asked_[near] = number_, next.push_back(near);
                return false;
            });
        return next;
    }

    const Layout& layout_;
    std::span<const BlockLoad> now_;
    Carry& carry_;
    std::vector<char> known_;
    std::vector<std::int32_t> asked_;  // of each block the wave that it was put into last
    std::int32_t number_ = 0;
};

}  // namespace

std::vector<std::int64_t> Interval::loads(std::span<const std::int32_t> owners, int ranks) const {
    std::vector<std::int64_t> sums(static_cast<std::size_t>(ranks), 0);
    for (std::size_t b = 0; b < blocks.size(); ++b)
        if (owners[b] >= 0) sums[static_cast<std::size_t>(owners[b])] += load(b);
    return sums;
}

bool neighbour_key(const Layout& layout, Key key, int code, Key& result) {
    return layout.dimensions == 2 ? neighbour_in<2>(layout, key, code, result)
                                  : neighbour_in<3>(layout, key, code, result);
}

std::vector<Key> keys_of(std::span<const BlockLoad> blocks) {
    std::vector<Key> keys;
    keys.reserve(blocks.size());
    for (const BlockLoad& block : blocks) keys.push_back(block.key);
    return keys;
}

Carry carry_between(const Layout& layout, std::span<const Key> before, std::span<const BlockLoad> now) {
    Carry carry;
    carry.from.assign(now.size(), -1);
    std::vector<std::int32_t> waiting;
    for (std::size_t b = 0, o = 0; b < now.size(); ++b) {
        while (o < before.size() && before[o] < now[b].key) ++o;
        if (o < before.size() && before[o] == now[b].key)
            carry.from[b] = static_cast<std::int32_t>(o);
        else
            waiting.push_back(static_cast<std::int32_t>(b));
    }
    Inheritance(layout, now, carry).find(std::move(waiting));
    return carry;
}

std::vector<std::int32_t> Carry::owners(std::span<const std::int32_t> before, const Interval& now, const Layout& layout,
                                        const Partitioner& partitioner) const {
    std::vector<std::int32_t> owner(now.blocks.size(), 0);
    for (std::size_t b = 0; b < owner.size(); ++b)
        if (from[b] >= 0) owner[b] = before[from[b]];
    for (const auto& [b, inherits_from] : inheriting) {
        const std::int32_t here = partitioner.owner_at(block_position(layout, now.blocks[b].key));
        owner[b] = here >= 0 ? here : owner[inherits_from];
    }
    return owner;
}

}  // namespace moraine
