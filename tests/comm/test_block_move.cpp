#include "comm/block_move.hpp"
#include "comm/swarm.hpp"

using namespace moraine;
using moraine::test::fraction;
using moraine::test::Swarm;

namespace {

template <class C>
void settle(C& swarm, std::uint64_t walkers, double length) {
    swarm.settle(walkers, [length](std::uint64_t id, int a) {
        return length * fraction(mix(mix(id) + static_cast<unsigned>(a)));
    });
}

}  // namespace

TEST_CASE_TEMPLATE("whole blocks arrive with every column and in list order, whatever the owners", Real, float,
                   double) {
    const Scene scene = test::periodic_scene(3, 3, 3, 3);
    Swarm<Real, 3> swarm(MPI_COMM_WORLD, scene);
    settle(swarm, 2000, 12);
    const auto before = swarm.rows();
    CHECK(before.size() == 2000);
    for (std::uint64_t round = 1; round < 8; ++round) {
        swarm.shuffle(round);
        CHECK(swarm.rows() == before);
        for (Key key : swarm.patch.binned().key) CHECK(swarm.owner_of(key, round) == swarm.comm.rank());
    }
}

TEST_CASE("what moved is counted, and nothing moves to where it is") {
    const Scene scene = test::periodic_scene(2, 5, 5, 1);
    Swarm<double, 2> swarm(MPI_COMM_WORLD, scene);
    settle(swarm, 1000, 20);
    const BlockMoveCount stay = swarm.shuffle(0);
    CHECK(stay.particles == 0);
    CHECK(stay.blocks == 0);
    const BinnedBlocks binned = swarm.patch.binned();
    std::int64_t blocks = 0, particles = 0;
    for (std::size_t b = 0; b < binned.key.size(); ++b) {
        if (swarm.owner_of(binned.key[b], 5) == swarm.comm.rank()) continue;
        ++blocks;
        particles += binned.count[b];
    }
    const BlockMoveCount moved = swarm.shuffle(5);
    CHECK(moved.blocks == blocks);
    CHECK(moved.particles == particles);
}

TEST_CASE("all blocks may go to one rank, and back; ranks may be left with nothing") {
    const Scene scene = test::periodic_scene(2, 4, 4, 1);
    Swarm<float, 2> swarm(MPI_COMM_WORLD, scene);
    settle(swarm, 500, 16);
    const auto before = swarm.rows();
    for (int owner = swarm.comm.size() - 1; owner >= 0; --owner) {
        const BinnedBlocks binned = swarm.patch.binned();
        BlockMoveCount moved;
        swarm.begin_epoch(
            move_blocks(swarm.comm, swarm.patch, binned, std::vector<std::int32_t>(binned.key.size(), owner), moved));
        CHECK(swarm.patch.count() == (swarm.comm.rank() == owner ? 500 : 0));
        CHECK(swarm.rows() == before);
    }
}

TEST_CASE("parts of one block that come from several ranks are joined in rank order") {
    const Comm comm(MPI_COMM_WORLD);
    Patch<Host, double, 2> patch({}, 3);
    const int n = comm.size();
    const auto me = static_cast<std::uint32_t>(comm.rank());
    BinnedBlocks mine;
    mine.key = {10, 20};
    mine.count = {1 + me, 2};
    mine.slot = patch.take_slots(3 + me);
    for (std::uint32_t s : mine.slot) {
        for (const ColumnBytes& c : patch.particles.columns())
            std::fill_n(c.data + s * c.row_bytes, c.row_bytes, std::byte{0});
        patch.particles.view().id[s] = 100 * me + s;
    }
    BlockMoveCount moved;
    const BinnedBlocks got = move_blocks(comm, patch, mine, {0, n - 1}, moved);
    const bool first = comm.rank() == 0, last = comm.rank() == n - 1;
    std::vector<std::uint64_t> expected;
    std::vector<Key> keys;
    const auto add = [&](Key key, auto from, auto to) {
        keys.push_back(key);
        for (std::uint64_t r = 0; r < static_cast<std::uint64_t>(n); ++r)
            for (std::uint64_t s = from(r); s < to(r); ++s) expected.push_back(100 * r + s);
    };
    if (first)
        add(
            10, [](auto) { return std::uint64_t(0); }, [](auto r) { return 1 + r; });
    if (last)
        add(
            20, [](auto r) { return 1 + r; }, [](auto r) { return 3 + r; });
    std::vector<std::uint64_t> ids;
    for (std::uint32_t s : got.slot) ids.push_back(patch.particles.view().id[s]);
    CHECK(got.key == keys);
    CHECK(ids == expected);
}
