#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "balance/block_graph.hpp"

using namespace moraine;

namespace {

std::vector<BlockLoad> blocks_at(const std::vector<BlockPosition<3>>& places) {
    std::vector<BlockLoad> blocks;
    for (const auto& at : places) blocks.push_back({Morton<3>::encode(at), 1, 1, -1});
    std::sort(blocks.begin(), blocks.end(), [](const BlockLoad& a, const BlockLoad& b) { return a.key < b.key; });
    return blocks;
}

/// Nodes that two blocks share; 0: no edge.
std::int32_t between(const BlockGraph& g, std::size_t a, std::size_t b) {
    for (std::int64_t k = g.first[a]; k < g.first[a + 1]; ++k)
        if (g.neighbour[static_cast<std::size_t>(k)] == static_cast<std::int32_t>(b))
            return g.shared[static_cast<std::size_t>(k)];
    return 0;
}

}  // namespace

TEST_CASE("faces, edges and corners of blocks share as many nodes as their tiles have in common") {
    const std::map<int, std::array<int, 3>> nodes{{2, {25, 5, 1}}, {3, {72, 24, 8}}, {4, {147, 63, 27}}};
    for (const auto& [width, shared] : nodes)
        for (int k = 0; k < 3; ++k) {
            const BlockPosition<3> other{1, k > 0 ? -1 : 0, k > 1 ? 1 : 0};
            const BlockGraph g = graph_of({3, {9, 9, 9}, {}, width}, blocks_at({{0, 0, 0}, other}));
            CHECK(between(g, 0, 1) == shared[static_cast<std::size_t>(k)]);
            CHECK(between(g, 1, 0) == shared[static_cast<std::size_t>(k)]);
        }
}

TEST_CASE("in 2-D a block has four neighbours by its faces and four by its corners") {
    std::vector<BlockLoad> blocks;
    for (int i = 0; i < 9; ++i) blocks.push_back({Morton<2>::encode({i % 3, i / 3}), 1, 1, -1});
    std::sort(blocks.begin(), blocks.end(), [](const BlockLoad& a, const BlockLoad& b) { return a.key < b.key; });
    const BlockGraph g = graph_of({2, {3, 3, 1}}, blocks);
    std::map<std::size_t, int> degrees;
    for (std::size_t b = 0; b < 9; ++b) ++degrees[static_cast<std::size_t>(g.first[b + 1] - g.first[b])];
    CHECK(degrees == std::map<std::size_t, int>{{3, 4}, {5, 4}, {8, 1}});
    CHECK(std::count(g.shared.begin(), g.shared.end(), 12) == 24);  // faces: 2 x 6 nodes, 12 of them, at both ends
    CHECK(std::count(g.shared.begin(), g.shared.end(), 4) == 16);
}

TEST_CASE("blocks that do not touch have no edge") {
    const BlockGraph g = graph_of({3, {9, 9, 9}}, blocks_at({{0, 0, 0}, {2, 0, 0}, {4, 4, 4}}));
    CHECK(g.neighbour.empty());
    CHECK(g.first == std::vector<std::int64_t>{0, 0, 0, 0});
    CHECK(graph_of({3, {9, 9, 9}}, {}).first.size() == 1);
}

TEST_CASE("a periodic axis joins its ends, and two blocks that meet on both sides share both overlaps") {
    const auto blocks = blocks_at({{0, 0, 0}, {4, 0, 0}});
    CHECK(between(graph_of({3, {5, 5, 5}, {true, false, false}}, blocks), 0, 1) == 72);
    CHECK(between(graph_of({3, {5, 5, 5}, {false, true, true}}, blocks), 0, 1) == 0);
    const auto pair = blocks_at({{0, 0, 0}, {1, 0, 0}});
    CHECK(between(graph_of({3, {2, 5, 5}, {true, false, false}}, pair), 0, 1) == 144);
    CHECK(graph_of({3, {1, 5, 5}, {true, false, false}}, blocks_at({{0, 0, 0}})).neighbour.empty());
}
