#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "balance/host_relabel.hpp"
#include "balance/partitioner.hpp"
#include "balance/relabel.hpp"

using namespace moraine;
using Owners = std::vector<std::int32_t>;

namespace {

struct World {
    Owners part_of;
    std::vector<BlockLoad> blocks;
    HostOfRank host;
};

World random_world(std::mt19937_64& random, int most_ranks) {
    World w;
    const auto below = [&](std::size_t n) { return static_cast<std::int32_t>(random() % n); };
    const std::size_t ranks = 1 + random() % static_cast<std::uint64_t>(most_ranks);
    for (std::size_t r = 0; r < ranks; ++r) w.host.push_back(below(3));
    Owners names(w.host);  // hosts are numbered by their lowest ranks
    Owners seen;
    for (std::int32_t& h : w.host) {
        const auto at = std::find(seen.begin(), seen.end(), h);
        const auto number = static_cast<std::int32_t>(at - seen.begin());
        if (at == seen.end()) seen.push_back(h);
        h = number;
    }
    for (std::size_t b = 0, n = 1 + random() % 16; b < n; ++b) {
        w.part_of.push_back(below(ranks));
        const std::int64_t particles = below(20);
        w.blocks.push_back({b, particles, particles, below(ranks + 1) - 1});
    }
    return w;
}

/// Neighbours p, p + 1 on different hosts.
int crossings(const Owners& rank_of, const HostOfRank& host) {
    int n = 0;
    for (std::size_t p = 1; p < rank_of.size(); ++p) n += host[rank_of[p]] != host[rank_of[p - 1]];
    return n;
}

/// Particles that stay on their host, and on their rank.
std::pair<std::int64_t, std::int64_t> staying(const World& w, const Owners& rank_of) {
    std::pair<std::int64_t, std::int64_t> stay{0, 0};
    for (std::size_t b = 0; b < w.blocks.size(); ++b) {
        const std::int32_t from = w.blocks[b].owner, to = rank_of[w.part_of[b]];
        if (from < 0) continue;
        if (w.host[from] == w.host[to]) stay.first += w.blocks[b].particles;
        if (from == to) stay.second += w.blocks[b].particles;
    }
    return stay;
}

Owners all_ranks(std::size_t n) {
    Owners ranks(n);
    std::iota(ranks.begin(), ranks.end(), 0);
    return ranks;
}

/// Owners of now, if `rank_of` named the parts.
void hold(World& w, const Owners& rank_of) {
    for (std::size_t b = 0; b < w.blocks.size(); ++b) w.blocks[b].owner = rank_of[w.part_of[b]];
}

}  // namespace

TEST_CASE("of all assignments none crosses hosts less, or so keeps more on a host, or with these hosts on a rank") {
    std::mt19937_64 random(1);
    int several = 0, differs = 0;
    for (int round = 0; round < 600; ++round) {
        const World w = random_world(random, 7);
        const Owners mine = relabel_on_hosts(w.blocks, w.part_of, w.host);
        Owners sorted = mine;
        std::sort(sorted.begin(), sorted.end());
        REQUIRE(sorted == all_ranks(w.host.size()));
        several += host_count(w.host) > 1;
        differs += mine != relabel(w.blocks, w.part_of, static_cast<int>(w.host.size()));
        const int crossed = crossings(mine, w.host);
        const auto kept = staying(w, mine);
        const auto hosts_of_parts = [&](const Owners& rank_of) {
            Owners hosts;
            for (std::int32_t rank : rank_of) hosts.push_back(w.host[rank]);
            return hosts;
        };
        const Owners my_hosts = hosts_of_parts(mine);
        Owners other = all_ranks(w.host.size());
        int least = crossed;
        auto most_on_host = kept.first, most_on_rank = kept.second;
        do {
            const int n = crossings(other, w.host);
            least = std::min(least, n);
            if (n != crossed) continue;
            const auto stay = staying(w, other);
            most_on_host = std::max(most_on_host, stay.first);
            if (hosts_of_parts(other) == my_hosts) most_on_rank = std::max(most_on_rank, stay.second);
        } while (std::next_permutation(other.begin(), other.end()));
        REQUIRE(least == crossed);
        REQUIRE(most_on_host == kept.first);
        REQUIRE(most_on_rank == kept.second);
    }
    CHECK(several > 300);
    CHECK(differs > 200);
}

TEST_CASE("nothing moves when the parts have not changed and every host holds a run of them") {
    std::mt19937_64 random(2);
    for (const std::size_t hosts : {2, 5, 20})
        for (const std::size_t each : {1, 4, 16}) {
            World w;
            for (std::size_t r = 0; r < hosts * each; ++r)
                w.host.push_back(static_cast<std::int32_t>(r % hosts));  // ranks of a host are not in a row
            for (std::size_t b = 0; b < 3 * w.host.size(); ++b) {
                const auto particles = static_cast<std::int64_t>(1 + random() % 9);
                w.part_of.push_back(static_cast<std::int32_t>(b / 3));
                w.blocks.push_back({b, particles, particles, -1});
            }
            Owners order = all_ranks(hosts), rank_of;
            std::shuffle(order.begin(), order.end(), random);
            for (const std::int32_t h : order) {
                Owners ranks;
                for (std::size_t k = 0; k < each; ++k) ranks.push_back(h + static_cast<std::int32_t>(k * hosts));
                std::shuffle(ranks.begin(), ranks.end(), random);
                rank_of.insert(rank_of.end(), ranks.begin(), ranks.end());
            }
            hold(w, rank_of);
            CHECK(relabel_on_hosts(w.blocks, w.part_of, w.host) == rank_of);
        }
}

TEST_CASE("what nobody holds goes to hosts in order, and so does natural order") {
    const HostOfRank host{0, 1, 0, 1, 2};
    std::vector<BlockLoad> blocks;
    for (std::uint64_t b = 0; b < 5; ++b) blocks.push_back({b, 5, 5, -1});
    CHECK(relabel_on_hosts(blocks, all_ranks(5), host) == Owners{0, 2, 1, 3, 4});
    CHECK(ranks_by_host(host) == Owners{0, 2, 1, 3, 4});
}

TEST_CASE("every partitioner that cuts by load gives a host one run of the curve, and owners as balanced") {
    const HostOfRank host{0, 1, 0, 1, 0, 1};
    std::vector<BlockLoad> blocks;
    for (Key key = 0; key < 64; ++key) blocks.push_back({key, 1 + static_cast<std::int64_t>(key % 3), 1, -1});
    const Layout layout{2, {8, 8, 1}};
    for (const char* name : {"morton", "hilbert", "equal-slabs"}) {
        CAPTURE(name);
        BalanceSpec spec;
        spec.partitioner = name;
        const auto plain = make_partitioner(spec, layout, 6), on_hosts = make_partitioner(spec, layout, 6, host);
        const Owners parts = plain->owners(blocks, 0), owners = on_hosts->owners(blocks, 0);
        Owners rank_of(6, -1);
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            if (rank_of[parts[b]] < 0) rank_of[parts[b]] = owners[b];
            REQUIRE(rank_of[parts[b]] == owners[b]);
        }
        CHECK(crossings(rank_of, host) == 1);
        for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].owner = owners[b];
        for (const Option& option : on_hosts->options(blocks, 1)) {
            Owners natural;  // the ranks in the order of the parts
            for (std::size_t b = 0; b < blocks.size(); ++b) rank_of[parts[b]] = option.owners[b];
            CHECK(crossings(rank_of, host) == 1);
        }
        for (BlockLoad& block : blocks) block.owner = -1;
    }
}

TEST_CASE("parts are numbered by the medians of their blocks along the curve, those without a block last") {
    CHECK(numbered_along_curve({3, 3, 1, 0, 1, 3, 0}, 5) == Owners{0, 0, 1, 2, 1, 0, 2});
    CHECK(numbered_along_curve({2, 0, 2, 2, 1}, 3) == Owners{1, 0, 1, 1, 2});
}
