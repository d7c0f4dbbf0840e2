#include <doctest/doctest.h>

#include <random>
#include <set>

#include "comm/block_index.hpp"

using namespace moraine;

namespace {

template <int Dim>
void finds_what_is_there(std::uint64_t seed) {
    CAPTURE(seed);
    std::mt19937_64 random(seed);
    std::set<Key> some;
    const std::size_t wanted = seed * seed * 3;
    while (some.size() < wanted) some.insert(random() % (8 * wanted));
    const std::vector<Key> keys(some.begin(), some.end());
    const BlockIndex<Dim> index(keys);
    CHECK(index.keys() == keys);
    for (std::size_t i = 0; i < keys.size(); ++i) REQUIRE(index.find(keys[i]) == static_cast<std::int32_t>(i));
    for (Key key = 0; key < 8 * wanted + 20; ++key)
        if (!some.contains(key)) REQUIRE(index.find(key) == -1);
    for (std::size_t f = 1; f < index.families().size(); ++f)
        REQUIRE(index.families()[f - 1].parent < index.families()[f].parent);
}

}  // namespace

TEST_CASE("a block index finds each of its blocks at its place, and no other") {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        finds_what_is_there<2>(seed);
        finds_what_is_there<3>(seed);
    }
}

TEST_CASE("the index of families is that of their blocks") {
    const std::vector<Family> families{{1, 0, 0b0110}, {4, 0, 0b1000}, {5, 0, 0b1111}};
    const BlockIndex<2> index(families);
    const std::vector<Key> keys{5, 6, 19, 20, 21, 22, 23};
    CHECK(index.keys() == keys);
    for (std::size_t i = 0; i < keys.size(); ++i) CHECK(index.find(keys[i]) == static_cast<std::int32_t>(i));
    CHECK(index.family(4) == 1);
    CHECK(index.family(2) == -1);
}
