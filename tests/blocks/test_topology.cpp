#include "blocks/random_world.hpp"
#include "blocks/topology.hpp"

using namespace moraine;
using moraine::test::World;

namespace {

template <int Dim>
void is_occupied_and_apron(std::uint64_t seed) {
    CAPTURE(seed);
    const World<Dim> world(seed, 5);
    const Topology<Dim> t = world.topology();
    std::set<Key> expected;
    BlockPosition<Dim> near{};
    for (const OccupiedBlock& b : world.occupied)
        for (int code = 0; code < Block<Dim>::offsets; ++code)
            if (world.neighbour(Morton<Dim>::decode(b.key), code, near)) expected.insert(Morton<Dim>::encode(near));
    REQUIRE(t.keys == std::vector<Key>(expected.begin(), expected.end()));
    REQUIRE(t.owner.size() == t.keys.size());
    for (std::size_t i = 0; i < t.keys.size(); ++i) {
        REQUIRE(t.find(t.keys[i]) == static_cast<std::int64_t>(i));
        std::int32_t owner = -1;
        const auto ask = [&](Key key) {
            for (const OccupiedBlock& b : world.occupied)
                if (b.key == key && owner < 0) owner = b.owner;
        };
        ask(t.keys[i]);
        for (int code = 0; code < Block<Dim>::offsets; ++code)
            if (world.neighbour(Morton<Dim>::decode(t.keys[i]), code, near)) ask(Morton<Dim>::encode(near));
        REQUIRE(t.owner[i] == owner);
    }
    world.each_position([&](const BlockPosition<Dim>& at) {
        const Key key = Morton<Dim>::encode(at);
        if (!expected.contains(key)) CHECK(t.find(key) == -1);
    });
}

}  // namespace

TEST_CASE("the topology is the occupied blocks and their neighbours; empty ones go to the first occupied neighbour") {
    for (std::uint64_t seed = 0; seed < 60; ++seed) is_occupied_and_apron<2>(seed);
    for (std::uint64_t seed = 0; seed < 30; ++seed) is_occupied_and_apron<3>(seed);
}

TEST_CASE("a static partitioner says who owns an empty block, but not who owns an occupied one") {
    World<2> world(7, 3);
    const Topology<2> t = make_topology<2>(world.domain, world.occupied, [](const BlockPosition<2>&) { return 9; });
    for (std::size_t i = 0; i < t.keys.size(); ++i) CHECK((t.owner[i] == 9) == !world.is_occupied(t.keys[i]));
}

TEST_CASE("an empty block keeps its owner from one topology to the next") {
    const auto nobody = [](const BlockPosition<2>&) { return -1; };
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        World<2> world(seed, 4);
        const Topology<2> old = world.topology();
        std::vector<OccupiedBlock> now;  // half of them become empty, and some of the apron is entered
        for (std::size_t i = 0; i < old.keys.size(); ++i)
            if (mix(seed ^ mix(old.keys[i] + 1)) % 2)
                now.push_back({old.keys[i], world.is_occupied(old.keys[i]) ? old.owner[i] : 7});
        const Topology<2> fresh = make_topology<2>(world.domain, now, nobody);
        const Topology<2> next = make_topology<2>(world.domain, now, nobody, &old);
        REQUIRE(next.keys == fresh.keys);
        for (std::size_t i = 0; i < next.keys.size(); ++i) {
            const auto at = std::find_if(now.begin(), now.end(), [&](const auto& b) { return b.key == next.keys[i]; });
            const std::int64_t was = old.find(next.keys[i]);
            if (at != now.end())
                CHECK(next.owner[i] == at->owner);
            else
                CHECK(next.owner[i] == (was < 0 ? fresh.owner[i] : old.owner[static_cast<std::size_t>(was)]));
        }
    }
}

TEST_CASE("blocks wrap along periodic axes only") {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 0.5;
    scene.max = {6, 5, 0};
    scene.periodic[0] = true;
    const DomainBlocks<2> domain(scene);
    CHECK(domain.count == BlockPosition<2>{3, 3});
    CHECK(domain.nodes == BlockPosition<2>{12, 10});
    for (auto [from, to] : {std::pair{-1, 2}, {3, 0}, {-3, 0}, {7, 1}, {1, 1}}) {
        BlockPosition<2> at{from, 1};
        CHECK(domain.wrap(at));
        CHECK(at[0] == to);
    }
    for (int y : {-1, 3}) {
        BlockPosition<2> at{-1, y};
        CHECK(!domain.wrap(at));
        CHECK(at[0] == 2);  // wrapped all the same
    }
}

TEST_CASE("the blocks of a domain hold every binning place up to its upper face, and no more") {
    for (moraine::Shape shape : {moraine::Shape::linear, moraine::Shape::quadratic, moraine::Shape::cubic})
        for (int cells = 1; cells < 20; ++cells) {
            Scene scene;
            scene.dimensions = 3;
            scene.cell = 0.1;
            scene.shape = shape;
            scene.max = {0.1 * cells, 0.1 * cells, 0.1 * cells};
            const DomainBlocks<3> domain(scene);
            const double top = cells + stencil_of(shape).offset();
            CHECK(domain.nodes[1] == cells);
            CHECK(4 * domain.count[1] > top);
            CHECK(4 * (domain.count[1] - 1) <= top);
        }
}
