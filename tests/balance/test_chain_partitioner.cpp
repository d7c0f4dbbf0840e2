#include <doctest/doctest.h>

#include <chrono>
#include <numeric>
#include <set>

#include "balance/block_graph.hpp"
#include "balance/chain_partitioner.hpp"
#include "balance/cut.hpp"
#include "balance/load.hpp"
#include "balance/run_loads.hpp"

using namespace moraine;
using Owners = std::vector<std::int32_t>;

namespace {

ChainPartitioner hilbert(const Layout& layout, int ranks) {
    return {"hilbert", ranks,
            [layout](std::span<const BlockLoad> blocks) { return links_along_hilbert(layout, blocks); }};
}

ChainPartitioner equal_slabs(const Layout& layout, int axis, int ranks) {
    return {"equal-slabs", ranks,
            [=](std::span<const BlockLoad> blocks) { return links_by_layer(layout, axis, blocks); }};
}

/// Nodes that blocks of different owners share.
std::int64_t cut_nodes(const std::vector<BlockLoad>& blocks, const Owners& owners) {
    const BlockGraph g = graph_of(run_layout, blocks);
    std::int64_t nodes = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b)
        for (std::int64_t k = g.first[b]; k < g.first[b + 1]; ++k)
            if (owners[b] != owners[static_cast<std::size_t>(g.neighbour[static_cast<std::size_t>(k)])])
                nodes += g.shared[static_cast<std::size_t>(k)];
    return nodes / 2;
}

LoadSummary loads(const std::vector<BlockLoad>& blocks, const Owners& owners, int ranks) {
    return summary_of(loads_of_ranks(blocks, owners, ranks));
}

/// A quarter of a flat heap with its top at the origin.
std::vector<BlockLoad> large_heap(int radius) {
    std::vector<BlockLoad> blocks;
    for (int z = 0; 3 * z < radius; ++z)
        for (int y = 0; y < radius; ++y)
            for (int x = 0; x < radius; ++x) {
                if (x * x + y * y + 9 * z * z >= radius * radius) continue;
                const std::int64_t load = 400 + (7 * x + 13 * y + 29 * z) % 113;
                blocks.push_back({Morton<3>::encode({x, y, z}), load, load, -1});
            }
    std::sort(blocks.begin(), blocks.end(), [](const BlockLoad& a, const BlockLoad& b) { return a.key < b.key; });
    return blocks;
}

}  // namespace

TEST_CASE("hilbert cuts its curve as exactly as morton, and has fewer nodes between ranks") {
    std::int64_t by_morton = 0, by_hilbert = 0;
    for (const auto& [step, blocks] : loads_of_run())
        for (int ranks : {4, 8, 16, 32}) {
            const Links links = links_along_hilbert(run_layout, blocks);
            std::vector<std::int64_t> weights(blocks.size());
            for (std::size_t b = 0; b < blocks.size(); ++b)
                weights[static_cast<std::size_t>(links[b])] = blocks[b].weight;
            const Owners owners = hilbert(run_layout, ranks).owners(blocks, 0);
            CHECK(loads(blocks, owners, ranks).max == heaviest_part(weights, exact_cut(weights, ranks)));
            by_hilbert += cut_nodes(blocks, owners);
            by_morton += cut_nodes(blocks, ChainPartitioner("morton", ranks, links_along_morton).owners(blocks, 0));
        }
    MESSAGE("nodes between ranks: morton " << by_morton << ", hilbert " << by_hilbert);
    CHECK(by_hilbert < by_morton);
}

TEST_CASE("equal slabs are whole layers of blocks, contiguous along the axis, with the least heaviest slab") {
    for (const auto& [step, blocks] : loads_of_run())
        for (int axis : {0, 1, 2})
            for (int ranks : {1, 2, 3, 5}) {
                const Owners owners = equal_slabs(run_layout, axis, ranks).owners(blocks, 0);
                std::map<std::int32_t, std::set<std::int32_t>> owners_of_layer;
                std::map<std::int32_t, std::int64_t> weight_of_layer;
                for (std::size_t b = 0; b < blocks.size(); ++b) {
                    const std::int32_t layer =
                        block_position(run_layout, blocks[b].key)[static_cast<std::size_t>(axis)];
                    owners_of_layer[layer].insert(owners[b]);
                    weight_of_layer[layer] += blocks[b].weight;
                }
                std::vector<std::int64_t> weights;
                Owners along;
                for (const auto& [layer, ranks_there] : owners_of_layer) {
                    REQUIRE(ranks_there.size() == 1);
                    along.push_back(*ranks_there.begin());
                    weights.push_back(weight_of_layer[layer]);
                }
                CHECK(std::is_sorted(along.begin(), along.end()));
                CHECK(loads(blocks, owners, ranks).max == heaviest_part(weights, exact_cut(weights, ranks)));
            }
}

TEST_CASE("empty layers are no links of the chain") {
    std::vector<BlockLoad> blocks;
    for (int x : {2, 2, 7, 9}) blocks.push_back({Morton<2>::encode({x, static_cast<int>(blocks.size())}), 1, 1, -1});
    CHECK(links_by_layer({2, {12, 4, 1}}, 0, blocks) == Links{0, 0, 1, 2});
}

TEST_CASE("equal slabs follow the load when it moves") {
    std::vector<BlockLoad> blocks;
    for (int x = 0; x < 12; ++x) blocks.push_back({Morton<2>::encode({x, 0}), 10, 10, x / 6});
    const Layout strip{2, {12, 1, 1}};
    for (int x = 0; x < 4; ++x) blocks[static_cast<std::size_t>(x)].weight = 40;
    const Owners owners = equal_slabs(strip, 0, 2).owners(blocks, 0);
    CHECK(std::count(owners.begin(), owners.end(), 0) == 3);
}

TEST_CASE("options to choose from are natural, relabelled and least migration, the last when somebody holds blocks") {
    auto blocks = loads_of_run().begin()->second;
    const ChainPartitioner morton("morton", 4, links_along_morton);
    CHECK(morton.options(blocks, 0).size() == 2);
    const Owners natural = morton.owners(blocks, 0);
    for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].owner = (natural[b] + 1) % 4;
    const std::vector<Option> options = morton.options(blocks, 1);
    REQUIRE(options.size() == 3);
    CHECK(options[0].kind == PlanKind::natural);
    CHECK(options[0].owners == natural);
    CHECK(options[1].kind == PlanKind::relabelled);
    CHECK(options[1].owners == present_owners(blocks));
    CHECK(options[2].kind == PlanKind::least);
    CHECK(options[2].owners == present_owners(blocks));
}

TEST_CASE("50 000 blocks are partitioned for 1024 ranks along a curve in well under a second, options and all") {
    auto blocks = large_heap(66);
    REQUIRE(blocks.size() > 50000);
    const Layout layout{3, {66, 66, 22}};
    for (const ChainPartitioner& curve :
         {ChainPartitioner("morton", 1024, links_along_morton), hilbert(layout, 1024)}) {
        for (BlockLoad& block : blocks) block.owner = -1;
        const auto start = std::chrono::steady_clock::now();
        const Owners owners = curve.owners(blocks, 0);
        const auto cut = std::chrono::steady_clock::now();
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            blocks[b].owner = owners[b];
            blocks[b].weight = blocks[b].particles * static_cast<std::int64_t>(900 + b / 200) / 1000;
        }
        const auto again = std::chrono::steady_clock::now();
        REQUIRE(curve.options(blocks, 1).size() == 3);
        const auto end = std::chrono::steady_clock::now();
        const double seconds[] = {std::chrono::duration<double>(cut - start).count(),
                                  std::chrono::duration<double>(end - again).count()};
        MESSAGE(std::string(curve.name())
                << ": owners " << seconds[0] * 1e3 << " ms, options " << seconds[1] * 1e3 << " ms");
        CHECK(seconds[0] < 2);  // 1 and 16 ms, options 150 ms; the margin is for sanitizers and busy machines
        CHECK(seconds[1] < 5);
        CHECK(loads(blocks, owners, 1024).imbalance() < 1.2);
    }
}
