#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <thread>

#include "blocks/next_epoch.hpp"
#include "blocks/random_world.hpp"

using namespace moraine;
using moraine::test::World;

namespace {

constexpr int ranks = 4;

std::int32_t nobody(const BlockPosition<2>&) {
    return -1;
}

/// Tables of all ranks.
struct Everybody {
    std::vector<std::unique_ptr<NextEpoch<2>>> next;
    std::map<Key, std::int32_t> owner;  ///< by the tables

    explicit Everybody(const World<2>& world) {
        for (int r = 0; r < ranks; ++r) {
            next.push_back(std::make_unique<NextEpoch<2>>(world.domain, world.stencil, r, nobody));
            note(next.back()->make(world.occupied), r);
        }
    }

    void note(const EpochTables<2>& tables, int rank) {
        for (Key key : tables.own) owner[key] = rank;
    }

    /// Blocks that are chosen of those that there are, by rank.
    template <class Chosen>
    void start(const Chosen& chosen, bool async) {
        std::vector<Key> keys;
        std::vector<std::int64_t> counts;
        for (int r = 0; r < ranks; ++r) {
            counts.push_back(0);
            for (const auto& [key, of] : owner)
                if (of == r && chosen(key)) keys.push_back(key), ++counts.back();
        }
        for (auto& one : next) one->start(keys, counts, async);
    }
};

}  // namespace

TEST_CASE("a block has one owner in an epoch and in the next, so that who walks in meanwhile is at home in both") {
    for (std::uint64_t seed = 0; seed < 40; ++seed)
        for (bool async : {true, false}) {
            CAPTURE(seed);
            CAPTURE(async);
            const World<2> world(seed, ranks);
            Everybody all(world);
            const std::map<Key, std::int32_t> before = all.owner;
            const auto chosen = [&](Key key) { return mix(seed ^ mix(key + 1)) % 2 == 0; };
            all.start(chosen, async);
            all.owner.clear();
            bool any = false;
            for (int r = 0; r < ranks; ++r) {
                CHECK(all.next[static_cast<std::size_t>(r)]->under_way());
                const auto tables = all.next[static_cast<std::size_t>(r)]->take();
                CHECK(!all.next[static_cast<std::size_t>(r)]->under_way());
                if (tables) all.note(*tables, r), any = true;
            }
            if (!any) continue;  // nothing became occupied
            for (const auto& [key, owner] : before) {
                if (chosen(key)) REQUIRE(all.owner.contains(key));
                if (all.owner.contains(key)) CHECK(all.owner[key] == owner);
            }
        }
}

TEST_CASE("tables serve on where no block became occupied") {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const World<2> world(seed, ranks);
        Everybody all(world);
        all.start([&](Key key) { return world.is_occupied(key) && key % 2 == 0; }, false);
        for (auto& one : all.next) CHECK(!one->take());
    }
}

TEST_CASE("an epoch made at once forgets what was under way") {
    const World<2> world(3, ranks);
    NextEpoch<2> next(world.domain, world.stencil, 0, nobody);
    const EpochTables<2> first = next.make(world.occupied);
    next.start(first.own, {static_cast<std::int64_t>(first.own.size()), 0, 0, 0}, true);
    CHECK(next.make(world.occupied).own == first.own);
    CHECK(!next.under_way());
}

TEST_CASE("tables that are begun to be made while others still are come after them: one thread prepares at a time") {
    const World<2> world(3, ranks);
    std::atomic<int> inside = 0, most = 0;
    std::atomic<std::int64_t> last = 0;
    const auto prepare = [&](const EpochTables<2>& tables) {
        most = std::max<int>(most, ++inside);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        last = tables.serial;
        --inside;
    };
    NextEpoch<2> next(world.domain, world.stencil, 0, nobody, prepare);
    const EpochTables<2> first = next.make(world.occupied);
    for (int round = 0; round < 3; ++round) {
        next.start(first.own, {static_cast<std::int64_t>(first.own.size()), 0, 0, 0}, true);
        next.start_repartition(
            world.occupied.size(), [&] { return world.occupied; }, true);
        const auto tables = next.take();
        REQUIRE(tables.has_value());
        CHECK(tables->serial == last);
    }
    CHECK(most == 1);
}

TEST_CASE("tables are ready when their thread has made and prepared them, and at once where take() makes them") {
    const World<2> world(3, ranks);
    std::promise<void> gate;
    const std::shared_future<void> open = gate.get_future().share();
    NextEpoch<2> next(world.domain, world.stencil, 0, nobody, [open](const EpochTables<2>&) { open.wait(); });
    next.make(world.occupied);
    CHECK(next.is_ready());
    const auto occupied = [&] { return world.occupied; };
    next.start_repartition(world.occupied.size(), occupied, true);
    CHECK(!next.is_ready());
    gate.set_value();
    while (!next.is_ready()) std::this_thread::yield();
    CHECK(next.take().has_value());
    next.start_repartition(world.occupied.size(), occupied, false);
    CHECK(next.is_ready());
}
