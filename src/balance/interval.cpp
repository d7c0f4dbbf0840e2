#include "balance/interval.hpp"

#include <algorithm>

#include "core/block.hpp"

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

/// The first neighbour whose owner is known, or -1.
std::int64_t known_neighbour(const Layout& layout, std::span<const BlockLoad> now, std::int32_t b,
                             const std::vector<char>& known) {
    for (int code = 0; code < offsets_of(layout); ++code) {
        Key near = 0;
        if (!neighbour_key(layout, now[b].key, code, near)) continue;
        const std::int64_t i = index_of(now, near);
        if (i >= 0 && known[i]) return i;
    }
    return -1;
}

}  // namespace

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
    std::vector<char> known(now.size());
    for (std::size_t b = 0; b < now.size(); ++b) known[b] = carry.from[b] >= 0;
    while (!waiting.empty()) {
        const std::size_t done = carry.heirs.size();
        std::vector<std::int32_t> later;
        for (std::int32_t b : waiting) {
            const std::int64_t near = known_neighbour(layout, now, b, known);
            if (near >= 0)
                carry.heirs.emplace_back(b, static_cast<std::int32_t>(near));
            else
                later.push_back(b);
        }
        if (carry.heirs.size() == done) {  // an island
            const std::int32_t b = later.front();
            carry.heirs.emplace_back(b, std::max(b - 1, 0));
            later.erase(later.begin());
        }
        for (std::size_t h = done; h < carry.heirs.size(); ++h) known[carry.heirs[h].first] = 1;
        waiting = std::move(later);
    }
    return carry;
}

std::vector<std::int32_t> Carry::owners(std::span<const std::int32_t> before, const Interval& now, const Layout& layout,
                                        const Partitioner& partitioner) const {
    std::vector<std::int32_t> owner(now.blocks.size(), 0);
    for (std::size_t b = 0; b < owner.size(); ++b)
        if (from[b] >= 0) owner[b] = before[from[b]];
    for (const auto& [b, heir] : heirs) {
        const std::int32_t here = partitioner.owner_at(block_position(layout, now.blocks[b].key));
        owner[b] = here >= 0 ? here : owner[heir];
    }
    return owner;
}

}  // namespace moraine
