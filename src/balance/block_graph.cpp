#include "balance/block_graph.hpp"

#include <algorithm>

#include "core/data/block.hpp"

namespace moraine {
namespace {

template <int Dim>
std::int32_t shared_nodes(int width, int code) {
    std::int32_t nodes = 1;
    for (int a = 0; a < Dim; ++a) nodes *= Block<Dim>::offset(code, a) != 0 ? width - 1 : tile_side(width);
    return nodes;
}

template <int Dim>
std::int64_t neighbour_of(const Layout& layout, std::span<const BlockLoad> blocks, std::size_t block, int code) {
    BlockPosition<Dim> at = Morton<Dim>::decode(blocks[block].key);
    for (int a = 0; a < Dim; ++a) {
        at[a] += Block<Dim>::offset(code, a);
        if (layout.periodic[a]) at[a] = (at[a] % layout.blocks[a] + layout.blocks[a]) % layout.blocks[a];
    }
    const Key key = Morton<Dim>::encode(at);
    const auto found =
        std::lower_bound(blocks.begin(), blocks.end(), key, [](const BlockLoad& load, Key k) { return load.key < k; });
    return found != blocks.end() && found->key == key ? found - blocks.begin() : -1;
}

template <int Dim>
BlockGraph graph(const Layout& layout, std::span<const BlockLoad> blocks) {
    BlockGraph g;
    g.first.reserve(blocks.size() + 1);
    g.first.push_back(0);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        const std::ptrdiff_t mine = g.first.back();
        for (int code = 0; code < Block<Dim>::offsets; ++code) {
            const std::int64_t other = neighbour_of<Dim>(layout, blocks, b, code);
            if (other < 0 || other == static_cast<std::int64_t>(b)) continue;
            // around a short periodic axis the same block is met twice: one edge, both overlaps
            const auto met = std::find(g.neighbour.begin() + mine, g.neighbour.end(), other);
            if (met == g.neighbour.end()) {
                g.neighbour.push_back(static_cast<std::int32_t>(other));
                g.shared.push_back(shared_nodes<Dim>(layout.width, code));
            } else {
                g.shared[met - g.neighbour.begin()] += shared_nodes<Dim>(layout.width, code);
            }
        }
        g.first.push_back(static_cast<std::int64_t>(g.neighbour.size()));
    }
    return g;
}

}  // namespace

BlockGraph graph_of(const Layout& layout, std::span<const BlockLoad> blocks) {
    return layout.dimensions == 2 ? graph<2>(layout, blocks) : graph<3>(layout, blocks);
}

}  // namespace moraine
