#include <doctest/doctest.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <numeric>
#include <thread>

#include "balance/block_graph.hpp"
#include "balance/library_partitioner.hpp"
#include "balance/load.hpp"
#include "balance/metis.hpp"
#include "balance/relabel.hpp"
#include "balance/run_loads.hpp"
#include "balance/zoltan.hpp"
#include "core/data/error.hpp"

using namespace moraine;
using Owners = std::vector<std::int32_t>;

namespace {

std::vector<BlockLoad> row_of(const std::vector<std::int64_t>& weights) {
    std::vector<BlockLoad> blocks;
    for (std::size_t b = 0; b < weights.size(); ++b) blocks.push_back({b, weights[b], weights[b], -1});
    return blocks;
}

/// What is asked of the library, and an answer: block k to part k mod parts.
struct Asked {
    std::size_t blocks = 0;
    int parts = 0;
    std::int64_t weight = 0;
};

LibraryPartitioner spy(int ranks, Asked& asked) {
    return {"spy", ranks, [&asked](std::span<const BlockLoad> blocks, int parts) {
                asked = {blocks.size(), parts, blocks[0].weight};
                Owners answer(blocks.size());
                for (std::size_t b = 0; b < blocks.size(); ++b) answer[b] = static_cast<std::int32_t>(b) % parts;
                return answer;
            }};
}

std::int64_t cut_nodes(const std::vector<BlockLoad>& blocks, const Owners& owners) {
    const BlockGraph g = graph_of(run_layout, blocks);
    std::int64_t nodes = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b)
        for (std::int64_t k = g.first[b]; k < g.first[b + 1]; ++k)
            if (owners[b] != owners[static_cast<std::size_t>(g.neighbour[static_cast<std::size_t>(k)])])
                nodes += g.shared[static_cast<std::size_t>(k)];
    return nodes / 2;
}

}  // namespace

TEST_CASE("a library is not asked where there is nothing to decide") {
    Asked asked;
    CHECK(spy(1, asked).owners(row_of({3, 4, 5}), 0) == Owners{0, 0, 0});
    CHECK(spy(3, asked).owners(row_of({3, 4, 5}), 0) == Owners{0, 1, 2});
    CHECK(spy(9, asked).owners(row_of({3, 4}), 0).size() == 2);
    CHECK(spy(9, asked).owners({}, 0).empty());
    CHECK(asked.parts == 0);
}

TEST_CASE("a block heavier than the mean of the rest gets a rank of its own, and the library the others") {
    Asked asked;
    const Owners owners = spy(3, asked).owners(row_of({1, 100, 1, 1, 1, 1, 1, 1, 1}), 0);
    CHECK(asked.blocks == 8);
    CHECK(asked.parts == 2);
    CHECK(std::count(owners.begin(), owners.end(), owners[1]) == 1);
    const Owners two = spy(2, asked).owners(row_of({9, 1, 1, 1}), 0);
    CHECK(two == Owners{1, 0, 0, 0});
}

TEST_CASE("blocks without load are shared out by number") {
    Asked asked;
    spy(2, asked).owners(row_of({0, 0, 0, 0}), 0);
    CHECK(asked.weight == 1);
}

TEST_CASE("what a library says is given to the ranks that hold most of it") {
    Asked asked;
    auto blocks = row_of({5, 5, 5, 5});
    for (std::size_t b = 0; b < 4; ++b) blocks[b].owner = static_cast<std::int32_t>(b + 1) % 2;
    CHECK(spy(2, asked).owners(blocks, 0) == Owners{1, 0, 1, 0});
}

TEST_CASE("loads for METIS sum to 2^30 at most, in proportion, and no load vanishes") {
    CHECK(metis_loads(row_of({3, 0, 7})) == Owners{3, 0, 7});
    const std::int64_t huge = std::int64_t(1) << 60;
    const auto scaled = metis_loads(row_of({huge, 2 * huge, 1, 0}));
    CHECK(std::accumulate(scaled.begin(), scaled.end(), std::int64_t(0)) <= std::int64_t(1) << 30);
    CHECK(scaled[1] - 2 * scaled[0] <= 1);
    CHECK(scaled[0] > 100000000);
    CHECK(scaled[2] == 1);
    CHECK(scaled[3] == 0);
}

TEST_CASE("a graph that 32 bits cannot count is refused") {
    CHECK_NOTHROW(refuse_metis_graph(INT32_MAX, INT32_MAX));
    CHECK_THROWS_WITH_AS(refuse_metis_graph(std::int64_t(1) << 31, 5),
                         "balance.partitioner = \"metis\" (its 32 bits cannot count 2147483648 neighbours that share 5 "
                         "nodes). Use hilbert?",
                         InputError);
    CHECK_THROWS_AS(refuse_metis_graph(5, std::int64_t(1) << 31), InputError);
}

TEST_CASE("a signal that comes while METIS runs is no error of METIS, and reaches the program afterwards") {
    static volatile std::sig_atomic_t got;
    got = 0;
    const auto before = std::signal(SIGTERM, [](int) { got = 1; });
    const auto blocks = loads_of_run().begin()->second;
    std::atomic<bool> done = false;
    std::thread sender([&done, runner = pthread_self()] {
        while (!done) pthread_kill(runner, SIGTERM);
    });
    Owners owners;
    for (int k = 0; k < 3; ++k) CHECK_NOTHROW(owners = metis_parts(run_layout, blocks, 4));
    done = true;
    sender.join();
    CHECK(got == 1);
    CHECK(owners == metis_parts(run_layout, blocks, 4));
    std::signal(SIGTERM, before);
}

TEST_CASE("METIS and phg leave fewer nodes between ranks than a pseudo-random partition by far") {
    const auto blocks = loads_of_run().rbegin()->second;
    Owners random(blocks.size());
    for (std::size_t b = 0; b < random.size(); ++b) random[b] = static_cast<std::int32_t>(b * 2654435761U % 8);
    CHECK(cut_nodes(blocks, metis_parts(run_layout, blocks, 8)) < cut_nodes(blocks, random) / 4);
    CHECK(cut_nodes(blocks, zoltan_parts(ZoltanMethod::phg, run_layout, 50, blocks, 8)) <
          cut_nodes(blocks, random) / 4);
}

TEST_CASE("phg moves less when it knows the present owners, and the less the sooner it will be asked again") {
    auto blocks = loads_of_run().rbegin()->second;
    const Owners first = zoltan_parts(ZoltanMethod::phg, run_layout, 50, blocks, 8);
    std::int64_t at = 0;
    for (BlockLoad& block : blocks) block.weight = block.particles * (100 + at++ / 8) / 100;
    const Owners anew = zoltan_parts(ZoltanMethod::phg, run_layout, 50, blocks, 8);
    for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].owner = first[b];
    const auto moves = [&](const Owners& owners) { return moved(blocks, owners).particles; };
    const Owners often = zoltan_parts(ZoltanMethod::phg, run_layout, 1, blocks, 8);
    const Owners seldom = zoltan_parts(ZoltanMethod::phg, run_layout, 1000, blocks, 8);
    CHECK(moves(seldom) < moves(anew));
    CHECK(moves(often) < moves(seldom));
    CHECK(summary_of(loads_of_ranks(blocks, often, 8)).imbalance() < 1.05);
}
