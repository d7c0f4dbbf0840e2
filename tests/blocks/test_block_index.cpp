#include <omp.h>

#include <set>

#include "blocks/growth.hpp"
#include "blocks/in_order.hpp"
#include "blocks/random_world.hpp"

using namespace moraine;
using moraine::test::World;

namespace {

/// Calls f() with several numbers of threads.
template <class F>
void with_threads(const F& f) {
    const int before = omp_get_max_threads();
    for (int threads : {1, 2, 5}) {
        CAPTURE(threads);
        omp_set_num_threads(threads);
        f();
    }
    omp_set_num_threads(before);
}

template <int Dim>
std::vector<Key> keys_of(const World<Dim>& world) {
    std::vector<Key> keys;
    for (const OccupiedBlock& block : world.occupied) keys.push_back(block.key);
    return keys;
}

/// A random world whose axes have 1 to 7 blocks, periodic or not.
template <int Dim>
World<Dim> world_of(std::uint64_t seed) {
    World<Dim> world(seed, 1);
    for (std::size_t a = 0; a < Dim; ++a) {
        world.domain.count[a] = static_cast<std::int32_t>(1 + mix(seed * 4 + a) % 7);
        world.domain.periodic[a] = mix(seed * 4 + a) / 7 % 2;
    }
    world.occupied.clear();
    world.each_position([&](const BlockPosition<Dim>& at) {
        const Key key = Morton<Dim>::encode(at);
        if (mix(seed ^ mix(key)) % 4 <= seed % 4) world.occupied.push_back({key, 0});
    });
    std::sort(world.occupied.begin(), world.occupied.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
    return world;
}

template <int Dim>
void finds_its_keys(std::size_t n) {
    std::mt19937_64 random(n);
    std::set<Key> set;
    const Key origin = Morton<Dim>::encode({});
    while (set.size() < n) set.insert(origin + random() % (3 * n));
    const std::vector<Key> keys(set.begin(), set.end());
    with_threads([&] {
        const BlockIndex<Dim> index(keys);
        REQUIRE(index.keys() == keys);
        const auto wrong = [&](Key key) {
            const auto it = set.find(key);
            return index.find(key) != (it == set.end() ? -1 : std::distance(set.begin(), it));
        };
        for (std::size_t i = 0; i < n; ++i) REQUIRE(index.find(keys[i]) == static_cast<std::int32_t>(i));
        for (Key key = origin - 9; key < origin + 9; ++key) REQUIRE(!wrong(key));
        for (Key key = origin; key < origin + 3 * n; ++key)
            if (!set.contains(key)) REQUIRE(index.find(key) == -1);
    });
}

/// Position of a place of the family, wrapped; false: beyond an end that is not periodic.
template <int Dim>
bool position_of(const DomainBlocks<Dim>& domain, Key parent, int place, BlockPosition<Dim>& at) {
    at = Morton<Dim>::decode(parent << Dim);
    for (int a = 0; a < Dim; ++a) at[static_cast<std::size_t>(a)] += (place >> (2 * a) & 3) - 1;
    return domain.wrap(at);
}

template <int Dim>
void places_are_wrapped_positions(std::uint64_t seed) {
    const World<Dim> world = world_of<Dim>(seed);
    const BlockIndex<Dim> index(keys_of(world));
    BlockPosition<Dim> at{};
    for (const Family& family : index.families())
        for (Ends ends : {Ends::closed, Ends::open}) {
            const Places wanted = mix(family.parent + seed) | (seed % 2 ? ~Places(0) : 0);
            const auto blocks = blocks_at(index, Surroundings<Dim>(world.domain, family.parent, ends), wanted);
            for (int p = 0; p < Surroundings<Dim>::places; ++p) {
                const bool inside = position_of<Dim>(world.domain, family.parent, p, at) || ends == Ends::open;
                const std::int32_t there =
                    inside && (wanted >> p & 1u) ? index.find(Morton<Dim>::encode(at)) : std::int32_t(-1);
                REQUIRE(blocks[static_cast<std::size_t>(p)] == there);
            }
        }
}

template <int Dim>
void grows_by_neighbours(std::uint64_t seed) {
    const World<Dim> world = world_of<Dim>(seed);
    const std::vector<Key> keys = keys_of(world);
    std::set<Key> around(keys.begin(), keys.end()), upwards(keys.begin(), keys.end());
    BlockPosition<Dim> near{};
    for (Key key : keys)
        for (int code = 0; code < Block<Dim>::offsets; ++code) {
            const bool inside = world.neighbour(Morton<Dim>::decode(key), code, near);
            bool up = true;
            for (int a = 0; a < Dim; ++a) up = up && Block<Dim>::offset(code, a) >= 0;
            if (inside) around.insert(Morton<Dim>::encode(near));
            if (up) upwards.insert(Morton<Dim>::encode(near));
        }
    with_threads([&] {
        const BlockIndex<Dim> index(keys);
        REQUIRE(grown(index, world.domain, Reach::around).keys() == std::vector<Key>(around.begin(), around.end()));
        REQUIRE(grown(index, world.domain, Reach::upwards).keys() == std::vector<Key>(upwards.begin(), upwards.end()));
    });
}

}  // namespace

TEST_CASE("an index finds the place of each of its blocks, and no other block") {
    for (std::size_t n : {0, 1, 7, 300, 5000}) {
        finds_its_keys<2>(n);
        finds_its_keys<3>(n);
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

TEST_CASE("the places around a family are the blocks at their wrapped positions, however many blocks an axis has") {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        CAPTURE(seed);
        places_are_wrapped_positions<2>(seed);
        places_are_wrapped_positions<3>(seed);
    }
}

TEST_CASE("a set grows by all neighbours in the domain, or by all upper corners") {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        grows_by_neighbours<2>(seed);
        grows_by_neighbours<3>(seed);
    }
}

TEST_CASE("threads make the lists that one thread makes") {
    for (std::size_t n : {0, 5, 127, 128, 4001}) {
        std::vector<std::size_t> thirds, places;
        for (std::size_t i = 0; i < n; ++i)
            if (mix(i) % 3 == 0) thirds.push_back(i);
        for (std::size_t i = 0; i < n; ++i) places.insert(places.end(), mix(i) % 4, i);
        with_threads([&] {
            CHECK(chosen_of<std::size_t>(n, [](std::size_t i) { return mix(i) % 3 == 0; }) == thirds);
            std::vector<std::size_t> list;
            place_in_order(
                n, [](std::size_t i) { return mix(i) % 4; }, [&](std::size_t size) { list.resize(size); },
                [&](std::size_t i, std::size_t at) { std::fill_n(&list[at], mix(i) % 4, i); });
            CHECK(list == places);
            const Grouped groups = grouped_in_order(n, 4, [](std::size_t i) { return mix(i) % 4; });
            REQUIRE(groups.first.back() == n);
            for (std::size_t b = 0; b < 4; ++b)
                for (std::size_t k = groups.first[b]; k < groups.first[b + 1]; ++k) {
                    CHECK(mix(groups.item[k]) % 4 == b);
                    CHECK((k == groups.first[b] || groups.item[k - 1] < groups.item[k]));
                }
        });
    }
}
