#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <random>

#include "balance/cut.hpp"

using namespace moraine;
using Weights = std::vector<std::int64_t>;

namespace {

std::int64_t total_of(const Weights& w) {
    return std::accumulate(w.begin(), w.end(), std::int64_t(0));
}

/// The bottleneck by trying every cut.
std::int64_t exhaustive(const Weights& w, std::size_t from, int parts) {
    if (parts == 1) return std::accumulate(w.begin() + static_cast<long>(from), w.end(), std::int64_t(0));
    std::int64_t best = INT64_MAX;
    std::int64_t mine = 0;
    for (std::size_t to = from; to <= w.size(); ++to) {
        best = std::min(best, std::max(mine, exhaustive(w, to, parts - 1)));
        if (to < w.size()) mine += w[to];
    }
    return best;
}

constexpr std::int64_t none = INT64_MAX;

/// The bottleneck by trying every cut whose parts hold at most `most`; `none` if there is none.
std::int64_t exhaustive(const Weights& w, const MemoryLimit& memory, std::size_t from, int parts) {
    std::int64_t best = none, mine = 0, held = 0;
    for (std::size_t to = from; held <= memory.most; ++to) {
        if (parts > 1) best = std::min(best, std::max(mine, exhaustive(w, memory, to, parts - 1)));
        if (parts == 1 && to == w.size()) return mine;
        if (to == w.size()) break;
        mine += w[to], held += memory.held[to];
    }
    return best;
}

/// The bottleneck by bisection, with a probe that walks block by block.
std::int64_t bisected(const Weights& w, int parts) {
    std::int64_t low = 0;
    std::int64_t high = total_of(w);
    while (low < high) {
        const std::int64_t limit = low + (high - low) / 2;
        int used = 1;
        std::int64_t sum = 0;
        for (std::int64_t x : w) {
            if (x > limit) used = parts + 1;
            if (sum + x > limit) ++used, sum = 0;
            sum += x;
        }
        (used <= parts ? high : low) = used <= parts ? limit : limit + 1;
    }
    return low;
}

/// Each block goes to the share in which it begins.
Weights prefix_cut(const Weights& w, int parts) {
    Weights cuts(static_cast<std::size_t>(parts) + 1, static_cast<std::int64_t>(w.size()));
    const std::int64_t total = total_of(w);
    std::int64_t sum = 0;
    int p = 0;
    for (std::size_t i = 0; i < w.size(); sum += w[i++])
        while (p < parts && sum >= p * (total / parts)) cuts[static_cast<std::size_t>(p++)] = static_cast<long>(i);
    cuts[0] = 0;
    return cuts;
}

void check_shape(const Weights& cuts, std::size_t blocks, int parts) {
    REQUIRE(cuts.size() == static_cast<std::size_t>(parts) + 1);
    CHECK(cuts.front() == 0);
    CHECK(cuts.back() == static_cast<std::int64_t>(blocks));
    CHECK(std::is_sorted(cuts.begin(), cuts.end()));
    int empty = 0;
    for (std::size_t p = 0; p + 1 < cuts.size(); ++p) empty += cuts[p] == cuts[p + 1];
    CHECK(empty == std::max(0, parts - static_cast<int>(blocks)));
}

Weights random_weights(std::mt19937_64& random, std::size_t n) {
    const std::uint64_t range = std::uint64_t(1) << (1 + random() % 12);
    const std::uint64_t zeros = random() % 4;  // of four blocks
    Weights w(n);
    for (auto& x : w) x = random() % 4 < zeros ? 0 : static_cast<std::int64_t>(random() % range);
    return w;
}

}  // namespace

TEST_CASE("a chain is cut where its heaviest part is lightest") {
    CHECK(exact_cut(Weights{1, 2, 3, 4, 5, 6, 7, 8, 9}, 3) == Weights{0, 5, 7, 9});  // 15, 13, 17
    CHECK(exact_cut(Weights{1, 1, 1, 1, 1, 1}, 3) == Weights{0, 2, 4, 6});
    CHECK(heaviest_part(Weights{1, 2, 3, 4, 5, 6, 7, 8, 9}, Weights{0, 5, 7, 9}) == 17);
}

TEST_CASE("no cut of a short chain beats the exact one, and no part is empty without need") {
    std::mt19937_64 random(1);
    for (int round = 0; round < 5000; ++round) {
        const Weights w = random_weights(random, 1 + random() % 9);
        const int parts = static_cast<int>(1 + random() % 5);
        const Weights cuts = exact_cut(w, parts);
        CAPTURE(w);
        CAPTURE(parts);
        check_shape(cuts, w.size(), parts);
        REQUIRE(heaviest_part(w, cuts) == exhaustive(w, 0, parts));
    }
}

TEST_CASE("the exact cut of a long chain agrees with a bisection and never exceeds the prefix cut") {
    std::mt19937_64 random(2);
    int better = 0;
    for (int round = 0; round < 60; ++round) {
        const Weights w = random_weights(random, 1 + random() % 20000);
        const int parts = static_cast<int>(1 + random() % 300);
        const Weights cuts = exact_cut(w, parts);
        check_shape(cuts, w.size(), parts);
        const std::int64_t exact = heaviest_part(w, cuts);
        REQUIRE(exact == bisected(w, parts));
        const std::int64_t prefix = heaviest_part(w, prefix_cut(w, parts));
        REQUIRE(exact <= prefix);
        better += exact < prefix;
    }
    CHECK(better > 30);
}

TEST_CASE("under a limit of memory no cut of a short chain that keeps to it beats the exact one") {
    std::mt19937_64 random(5);
    int possible = 0, impossible = 0, binds = 0, costs = 0;
    for (int round = 0; round < 8000; ++round) {
        const Weights w = random_weights(random, 1 + random() % 9);
        const Weights held = random_weights(random, w.size());
        const int parts = static_cast<int>(1 + random() % 5);
        const auto all = static_cast<std::uint64_t>(total_of(held)), each = all / static_cast<std::uint64_t>(parts);
        const std::uint64_t most = round % 2 == 0 ? random() % (all + 2) : each + random() % (each + 2);
        const MemoryLimit memory{held, static_cast<std::int64_t>(most)};
        CAPTURE(w);
        CAPTURE(held);
        CAPTURE(memory.most);
        CAPTURE(parts);
        const std::int64_t best = exhaustive(w, memory, 0, parts);
        const auto cuts = exact_cut(w, parts, memory);
        REQUIRE(cuts.has_value() == (best != none));
        if (!cuts) {
            ++impossible;
            continue;
        }
        ++possible;
        check_shape(*cuts, w.size(), parts);
        if (total_of(w) > 0) REQUIRE(heaviest_part(w, *cuts) == best);
        REQUIRE(heaviest_part(held, *cuts) <= memory.most);
        const Weights free = exact_cut(w, parts);
        if (heaviest_part(held, free) <= memory.most) REQUIRE(heaviest_part(w, free) == best);
        binds += heaviest_part(held, free) > memory.most;
        costs += best > heaviest_part(w, free);
        if (total_of(w) > 0 && memory.most >= total_of(held)) REQUIRE(*cuts == free);
    }
    CHECK(possible > 3000);
    CHECK(impossible > 1000);
    CHECK(binds > 500);
    CHECK(costs > 150);
}

TEST_CASE("a long chain of sleepers and awake blocks is cut within the memory of its ranks") {
    Weights w(100000, 64), held(w.size(), 64);
    std::fill(w.begin(), w.begin() + 90000, 4);  // nine tenths sleep
    const std::int64_t mean = total_of(held) / 100;
    const auto load = [&](std::int64_t most) {
        const auto cuts = exact_cut(w, 100, {held, most});
        REQUIRE(cuts);
        REQUIRE(heaviest_part(held, *cuts) <= most);
        return heaviest_part(w, *cuts);
    };
    CHECK(2 * heaviest_part(held, exact_cut(w, 100)) > 5 * mean);  // by weight alone
    CHECK(load(20 * mean) == heaviest_part(w, exact_cut(w, 100)));
    CHECK(load(2 * mean) == 64 * 182);  // 45 parts of sleepers, 55 of the 10 000 blocks that are awake
    CHECK(load(mean) == 64 * 1000);
    CHECK_FALSE(exact_cut(w, 100, {held, mean - 1}));
    CHECK_FALSE(exact_cut(Weights{1, 1}, 5, {Weights{3, 4}, 3}));  // one block is too much
}

TEST_CASE("among the best cuts each part in turn is nearest to the mean of what remains") {
    CHECK(exact_cut(Weights{100, 1, 1, 1, 1, 1, 1, 1, 1}, 5) == Weights{0, 1, 3, 5, 7, 9});
    CHECK(exact_cut(Weights{1, 1, 1, 1, 100, 1, 1, 1, 1}, 5) == Weights{0, 4, 5, 6, 7, 9});
}

TEST_CASE("with more parts than blocks the first parts get one block each") {
    CHECK(exact_cut(Weights{5, 9}, 4) == Weights{0, 1, 2, 2, 2});
    CHECK(exact_cut(Weights{7}, 3) == Weights{0, 1, 1, 1});
    CHECK(exact_cut(Weights{}, 2) == Weights{0, 0, 0});
}

TEST_CASE("as many parts as are even enough: they are, and one more is not") {
    std::mt19937_64 random(3);
    for (int round = 0; round < 2000; ++round) {
        const Weights w = random_weights(random, 1 + random() % 60);
        const auto at_most = static_cast<std::int64_t>(1 + random() % (w.size() + 3));
        const double limit = 1 + static_cast<double>(random() % 5) / 8;
        const auto is_even = [&](std::int64_t parts) {
            return static_cast<double>(bisected(w, static_cast<int>(parts)) * parts) <=
                   limit * static_cast<double>(total_of(w));
        };
        const std::int64_t parts = even_parts(w, at_most, limit);
        REQUIRE((parts >= 1 && parts <= at_most));
        CHECK(is_even(parts));
        if (parts < at_most) CHECK_FALSE(is_even(parts + 1));
    }
    CHECK(even_parts(Weights(100, 0), 100, 1.25) == 100);
    CHECK(even_parts(Weights{}, 1, 1.25) == 1);
    CHECK(even_parts(Weights(2, INT64_MAX / 2 - 1), 2, 1.25) == 2);
}

TEST_CASE("one part takes all") {
    CHECK(exact_cut(Weights{5, 0, 9}, 1) == Weights{0, 3});
}

TEST_CASE("blocks without weight are cut by number") {
    CHECK(exact_cut(Weights(10, 0), 4) == Weights{0, 3, 6, 8, 10});
}

TEST_CASE("a total close to 2^63 does not overflow") {
    std::mt19937_64 random(4);
    for (int round = 0; round < 2000; ++round) {
        Weights w = random_weights(random, 1 + random() % 9);
        const int parts = static_cast<int>(1 + random() % 5);
        const std::int64_t scale = INT64_MAX / std::max<std::int64_t>(total_of(w), 1);
        const std::int64_t best = exhaustive(w, 0, parts);
        for (auto& x : w) x *= scale;
        REQUIRE(heaviest_part(w, exact_cut(w, parts)) == best * scale);
    }
    const std::int64_t big = INT64_MAX / 7;
    CHECK(exact_cut(Weights(7, big), 7) == Weights{0, 1, 2, 3, 4, 5, 6, 7});
    CHECK(exact_cut(Weights(7, big), 2) == Weights{0, 3, 7});
    CHECK(exact_cut(Weights{INT64_MAX - 3, 1, 1, 1}, 2) == Weights{0, 1, 4});
    CHECK(exact_cut(Weights{1, 1, 1, INT64_MAX - 3}, 3) == Weights{0, 2, 3, 4});
    CHECK(exact_cut(Weights(7, big), 1) == Weights{0, 7});
}

TEST_CASE("a million blocks are cut for 1024 ranks in a fraction of a second") {
    std::mt19937_64 random(3);
    Weights w(1000000);
    for (auto& x : w) x = static_cast<std::int64_t>(1 + random() % 512) * 400;
    double best = 1e9;
    for (int round = 0; round < 5; ++round) {
        const auto begin = std::chrono::steady_clock::now();
        const Weights cuts = exact_cut(w, 1024);
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
        best = std::min(best, wall.count());
        check_shape(cuts, w.size(), 1024);
        REQUIRE(heaviest_part(w, cuts) == bisected(w, 1024));
    }
    MESSAGE("best of 5: " << best * 1e3 << " ms");
    CHECK(best < 0.5);  // 4 ms on one core; the margin is for sanitizers and busy machines
}
