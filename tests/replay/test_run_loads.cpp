#include <doctest/doctest.h>

#include <numeric>

#include "balance/chain_partitioner.hpp"
#include "balance/cut.hpp"
#include "balance/load.hpp"
#include "balance/relabel.hpp"
#include "balance/run_loads.hpp"

using namespace moraine;
using Weights = std::vector<std::int64_t>;

namespace {

Weights weights_along(const std::vector<BlockLoad>& blocks, const Links& links) {
    Weights w(static_cast<std::size_t>(*std::max_element(links.begin(), links.end())) + 1, 0);
    for (std::size_t b = 0; b < blocks.size(); ++b) w[static_cast<std::size_t>(links[b])] += blocks[b].weight;
    return w;
}

/// Can `parts` parts of at most `limit` hold the chain? Link by link, without prefix sums.
bool holds(const Weights& w, int parts, std::int64_t limit) {
    std::int64_t capacity = limit;
    for (std::int64_t x : w) {
        if (x > limit) return false;
        if (x > capacity) --parts, capacity = limit;
        capacity -= x;
    }
    return parts > 0;
}

std::int64_t bisected(const Weights& w, int parts) {
    std::int64_t no = -1, yes = std::accumulate(w.begin(), w.end(), std::int64_t(0));
    while (yes - no > 1) {
        const std::int64_t middle = no + (yes - no) / 2;
        (holds(w, parts, middle) ? yes : no) = middle;
    }
    return yes;
}

/// The cut by prefix sums: a link goes where its middle falls.
std::int64_t prefix_bottleneck(const Weights& w, int parts) {
    const std::int64_t total = std::accumulate(w.begin(), w.end(), std::int64_t(0));
    Weights load(static_cast<std::size_t>(parts), 0);
    std::int64_t sum = 0;
    for (std::int64_t x : w) {
        const std::int64_t part = (2 * sum + x) * parts / (2 * total);
        load[static_cast<std::size_t>(std::min<std::int64_t>(part, parts - 1))] += x;
        sum += x;
    }
    return *std::max_element(load.begin(), load.end());
}

void give(std::vector<BlockLoad>& blocks, const std::vector<std::int32_t>& owners) {
    for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].owner = owners[b];
}

/// Owners of the blocks that were there before; the others are given to their predecessor on the Morton curve.
void inherit(std::vector<BlockLoad>& blocks, const std::vector<BlockLoad>& before) {
    std::int32_t last = before.front().owner;
    for (BlockLoad& block : blocks) {
        const auto at = std::lower_bound(before.begin(), before.end(), block.key,
                                         [](const BlockLoad& b, Key k) { return b.key < k; });
        if (at != before.end() && at->key == block.key) last = at->owner;
        block.owner = last;
    }
}

}  // namespace

TEST_CASE("on a run's loads the exact cut is what an independent bisection finds, and never above the prefix cut") {
    int better = 0, cases = 0;
    for (const auto& [step, blocks] : loads_of_run())
        for (const Links& links : {links_along_morton(blocks), links_along_hilbert(run_layout, blocks),
                                   links_by_layer(run_layout, 0, blocks)})
            for (int parts : {1, 2, 3, 4, 7, 16, 61, 200}) {
                CAPTURE(step);
                CAPTURE(parts);
                const Weights w = weights_along(blocks, links);
                const std::int64_t exact = heaviest_part(w, exact_cut(w, parts));
                REQUIRE(exact == bisected(w, parts));
                REQUIRE(exact <= prefix_bottleneck(w, parts));
                better += exact < prefix_bottleneck(w, parts);
                ++cases;
            }
    CHECK(cases == 96);
    CHECK(better > 25);
}

TEST_CASE("on a run's loads the least migration is within its tolerance and never moves more than the relabelled cut") {
    const auto loads = loads_of_run();
    std::int64_t natural = 0, relabelled = 0, least = 0;
    for (int ranks : {2, 3, 4, 7, 16, 61}) {
        const ChainPartitioner morton("morton", ranks, links_along_morton);
        std::vector<BlockLoad> before = loads.begin()->second;
        give(before, morton.owners(before, 0));
        for (auto at = std::next(loads.begin()); at != loads.end(); ++at) {
            std::vector<BlockLoad> blocks = at->second;
            inherit(blocks, before);
            const std::vector<Option> options = morton.options(blocks, 1);
            REQUIRE(options.size() == 3);
            const auto heaviest = [&](const Option& o) {
                return static_cast<double>(summary_of(loads_of_ranks(blocks, o.owners, ranks)).max);
            };
            CHECK(heaviest(options[0]) == heaviest(options[1]));
            CHECK(heaviest(options[2]) <= (1 + migration_tolerance) * heaviest(options[1]));
            natural += moved(blocks, options[0].owners).particles;
            relabelled += moved(blocks, options[1].owners).particles;
            least += moved(blocks, options[2].owners).particles;
            CHECK(moved(blocks, options[1].owners).particles <= moved(blocks, options[0].owners).particles);
            CHECK(moved(blocks, options[2].owners).particles <= moved(blocks, options[1].owners).particles);
            give(blocks, options[1].owners);
            before = blocks;
        }
    }
    MESSAGE("particles moved: natural " << natural << ", relabelled " << relabelled << ", least " << least);
    CHECK(least < relabelled);
    CHECK(relabelled < natural);
}
