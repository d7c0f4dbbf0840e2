#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "balance/relabel.hpp"

using namespace moraine;
using Owners = std::vector<std::int32_t>;

namespace {

std::vector<BlockLoad> blocks_of(const Owners& owners, const std::vector<std::int64_t>& particles) {
    std::vector<BlockLoad> blocks;
    for (std::size_t b = 0; b < owners.size(); ++b) blocks.push_back({b, particles[b], particles[b], owners[b]});
    return blocks;
}

Owners applied(const Owners& part_of, const Owners& rank_of) {
    Owners owners;
    for (std::int32_t part : part_of) owners.push_back(rank_of[static_cast<std::size_t>(part)]);
    return owners;
}

bool is_permutation_of_ranks(Owners rank_of, int ranks) {
    std::sort(rank_of.begin(), rank_of.end());
    Owners all(static_cast<std::size_t>(ranks));
    std::iota(all.begin(), all.end(), 0);
    return rank_of == all;
}

/// The least number of particles that any naming of the parts moves.
std::int64_t least_moved(const std::vector<BlockLoad>& blocks, const Owners& part_of, int ranks) {
    Owners rank_of(static_cast<std::size_t>(ranks));
    std::iota(rank_of.begin(), rank_of.end(), 0);
    std::int64_t least = INT64_MAX;
    do least = std::min(least, moved(blocks, applied(part_of, rank_of)).particles);
    while (std::next_permutation(rank_of.begin(), rank_of.end()));
    return least;
}

}  // namespace

TEST_CASE("a part goes to the rank that holds most of its particles") {
    // the cut between ranks 0 and 1 has moved, and they sit on the curve in the order 1, 0, 2
    const auto blocks = blocks_of({1, 1, 1, 0, 0, 2}, {10, 10, 10, 10, 10, 10});
    const Owners rank_of = relabel(blocks, Owners{0, 0, 1, 1, 1, 2}, 3);
    CHECK(rank_of == Owners{1, 0, 2});
    const Moved m = moved(blocks, applied({0, 0, 1, 1, 1, 2}, rank_of));
    CHECK(m.particles == 10);
    CHECK(m.blocks == 1);
}

TEST_CASE("nothing moves when the parts have not changed, whatever they are called") {
    std::mt19937_64 random(1);
    for (int round = 0; round < 1000; ++round) {
        const int ranks = static_cast<int>(1 + random() % 9);
        Owners name(static_cast<std::size_t>(ranks));
        std::iota(name.begin(), name.end(), 0);
        std::shuffle(name.begin(), name.end(), random);
        Owners part_of(1 + random() % 40);
        std::vector<std::int64_t> particles(part_of.size());
        for (auto& p : part_of) p = static_cast<std::int32_t>(random() % static_cast<std::uint64_t>(ranks));
        for (auto& n : particles) n = static_cast<std::int64_t>(random() % 3);  // blocks without particles stay too
        const Owners owners = applied(part_of, name);
        REQUIRE(applied(part_of, relabel(blocks_of(owners, particles), part_of, ranks)) == owners);
    }
}

TEST_CASE("relabelling never moves more than natural order, and keeps half of what can be kept") {
    std::mt19937_64 random(2);
    int better = 0;
    for (int round = 0; round < 4000; ++round) {
        const int ranks = static_cast<int>(1 + random() % 6);
        Owners owners(1 + random() % 14);
        Owners part_of(owners.size());
        std::vector<std::int64_t> particles(owners.size());
        for (auto& o : owners) o = static_cast<std::int32_t>(random() % static_cast<std::uint64_t>(ranks));
        for (auto& p : part_of) p = static_cast<std::int32_t>(random() % static_cast<std::uint64_t>(ranks));
        for (auto& n : particles) n = static_cast<std::int64_t>(random() % 20);
        const auto blocks = blocks_of(owners, particles);
        const Owners rank_of = relabel(blocks, part_of, ranks);
        REQUIRE(is_permutation_of_ranks(rank_of, ranks));
        const std::int64_t mine = moved(blocks, applied(part_of, rank_of)).particles;
        const std::int64_t natural = moved(blocks, part_of).particles;
        REQUIRE(mine <= natural);
        better += mine < natural;
        const std::int64_t total = std::accumulate(particles.begin(), particles.end(), std::int64_t(0));
        REQUIRE(2 * (total - mine) >= total - least_moved(blocks, part_of, ranks));
    }
    CHECK(better > 2000);
}

TEST_CASE("natural order is kept where greed would move more") {
    // overlaps: part 0 has 9 on rank 0 and 10 on rank 1, part 1 has 9 on rank 1
    const auto blocks = blocks_of({0, 1, 1}, {9, 10, 9});
    CHECK(relabel(blocks, Owners{0, 0, 1}, 2) == Owners{0, 1});
}

TEST_CASE("blocks that nobody holds take natural order and do not travel") {
    const auto blocks = blocks_of({-1, -1, -1}, {5, 5, 5});
    CHECK(relabel(blocks, Owners{0, 1, 2}, 4) == Owners{0, 1, 2, 3});
    CHECK(moved(blocks, Owners{0, 1, 2}).blocks == 0);
}

TEST_CASE("owners of a run on more ranks are nobody, and what they held travels") {
    const auto blocks = blocks_of({7, 0}, {5, 5});
    CHECK(relabel(blocks, Owners{0, 1}, 2) == Owners{1, 0});
}

TEST_CASE("equal overlaps go to the lower part and the lower rank") {
    const auto blocks = blocks_of({0, 1, 0, 1}, {5, 5, 5, 5});
    CHECK(relabel(blocks, Owners{1, 1, 0, 0}, 2) == Owners{0, 1});
}

TEST_CASE("a part without overlap keeps its number if that rank is free") {
    const auto blocks = blocks_of({-1, -1, 0}, {5, 5, 5});
    CHECK(relabel(blocks, Owners{0, 1, 2}, 3) == Owners{2, 1, 0});
}
