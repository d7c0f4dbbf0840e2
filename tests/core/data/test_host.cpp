#include <doctest/doctest.h>

#include <atomic>
#include <numeric>
#include <random>

#include "core/data/host.hpp"
#include "core/particles/particles.hpp"

using namespace moraine;

TEST_CASE("the prefix sum of counts ends with the total, and that of nothing is zero") {
    std::vector<std::uint32_t> count(1000);
    std::mt19937_64 random(1);
    for (auto& c : count) c = static_cast<std::uint32_t>(random() % 100);
    std::vector<std::uint64_t> first(count.size() + 1, 77);
    const std::uint64_t total = Host::scan(count.size(), count.data(), first.data());
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < count.size(); ++i) {
        REQUIRE(first[i] == sum);
        sum += count[i];
    }
    CHECK(first.back() == sum);
    CHECK(total == sum);
    std::uint32_t empty[1] = {9};
    CHECK(Host::scan(0, count.data(), empty) == 0);
    CHECK(empty[0] == 0);
}

TEST_CASE("an array keeps its contents when it grows, and its memory when it shrinks") {
    Host::Array<int> a;
    CHECK(a.size() == 0);
    std::size_t n = 0;
    for (std::size_t target : {1u, 10u, 11u, 1000u, 1001u, 100000u}) {
        a.resize(target);
        for (; n < target; ++n) a[n] = static_cast<int>(n);
        CHECK(a.size() == target);
        CHECK(a.capacity() >= target);
        bool same = true;
        for (std::size_t i = 0; i < n; ++i) same = same && a[i] == static_cast<int>(i);
        CHECK(same);
    }
    const int* place = a.data();
    a.resize(5);
    a.resize(100000);
    CHECK(a.data() == place);
    CHECK(a[99999] == 99999);
}

TEST_CASE("growing by one does not copy every time") {
    Host::Array<int> a;
    int moves = 0;
    const int* place = nullptr;
    for (std::size_t n = 1; n <= 100000; ++n) {
        a.resize(n);
        if (a.data() != place) ++moves;
        place = a.data();
    }
    CHECK(moves < 400);
}

TEST_CASE("arrays swap, are assigned and give their memory back") {
    Host::Array<double> a, b;
    a.assign(3, 1.5);
    b.assign(std::vector<double>{1, 2});
    a.swap(b);
    CHECK(a.size() == 2);
    CHECK(a[1] == 2);
    CHECK(b.size() == 3);
    CHECK(b[2] == 1.5);
    CHECK(b.span().size() == 3);
    b.release();
    CHECK(b.size() == 0);
    CHECK(b.capacity() == 0);
    b.resize(0);
    CHECK(b.size() == 0);
}

namespace {

struct Visit {
    struct Scratch {
        int marks[8];
    };
    std::atomic<int>* seen;

    void operator()(int i) const { ++seen[i]; }
    void operator()(const SoloTeam& team, int i, Scratch& scratch) const {
        team.each(8, [&](int k) { scratch.marks[k] = i; });
        team.sync();
        int same = 0;
        team.each(8, [&](int k) { same += scratch.marks[k] == i; });
        seen[i] += same == 8;
    }
};

}  // namespace

TEST_CASE("a loop visits every item once, and so does one over blocks with scratch") {
    for (int n : {0, 1, 63, 65, 1000}) {
        std::vector<std::atomic<int>> seen(static_cast<std::size_t>(n) + 1);
        Host::launch(n, Visit{seen.data()});
        Host::launch_teams(n, Visit{seen.data()});
        for (int i = 0; i < n; ++i) REQUIRE(seen[static_cast<std::size_t>(i)] == 2);
        CHECK(seen.back() == 0);
    }
}

TEST_CASE_TEMPLATE("permuting particles moves every column alike", Real, float, double) {
    Particles<Host, Real, 3> particles({true, true, true, 2, true});
    const std::size_t n = 257;
    particles.resize(n);
    std::mt19937_64 random(3);
    std::vector<std::vector<std::byte>> before;
    for (const ColumnBytes& c : particles.columns()) {
        for (std::size_t k = 0; k < n * c.row_bytes; ++k) c.data[k] = static_cast<std::byte>(random());
        before.emplace_back(c.data, c.data + n * c.row_bytes);
    }
    std::vector<std::uint32_t> order(200);  // fewer than there were: the others are dropped
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<std::uint32_t>(k * 91 % n);
    particles.permute(order.data(), order.size());
    CHECK(particles.size() == order.size());
    const std::vector<ColumnBytes> columns = particles.columns();
    for (std::size_t q = 0; q < columns.size(); ++q)
        for (std::size_t k = 0; k < order.size(); ++k)
            REQUIRE(std::memcmp(columns[q].data + k * columns[q].row_bytes,
                                before[q].data() + order[k] * columns[q].row_bytes, columns[q].row_bytes) == 0);
}

TEST_CASE("particles have only the columns that the scene needs") {
    Particles<Host, double, 2> few({});
    Particles<Host, double, 2> many({true, true, true, 2, true});
    CHECK(few.columns().size() == 8);
    CHECK(many.columns().size() == 13);  // the body force is no state
    CHECK(few.view().affine == nullptr);
    CHECK(few.view().history[0] == nullptr);
    many.resize(1);
    CHECK(many.view().affine != nullptr);
    CHECK(many.view().history[1] != nullptr);
    CHECK(few.row_bytes() == 8 + 2 + 16 + 16 + 8 + 8 + 8 + 32);
}
