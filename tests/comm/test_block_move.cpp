#include "comm/block_move.hpp"
#include "comm/crowd.hpp"

using namespace moraine;
using moraine::test::Crowd;
using moraine::test::fraction;

namespace {

template <class C>
void settle(C& crowd, std::uint64_t walkers, double length) {
    crowd.settle(walkers, [length](std::uint64_t id, int a) {
        return length * fraction(mix(mix(id) + static_cast<unsigned>(a)));
    });
}

}  // namespace

TEST_CASE_TEMPLATE("whole blocks arrive with every column and in list order, whatever the owners", Real, float,
                   double) {
    const Scene scene = test::periodic_scene(3, 3, 3, 3);
    Crowd<Real, 3> crowd(MPI_COMM_WORLD, scene);
    settle(crowd, 2000, 12);
    const auto before = crowd.rows();
    CHECK(before.size() == 2000);
    for (std::uint64_t round = 1; round < 8; ++round) {
        crowd.shuffle(round);
        CHECK(crowd.rows() == before);
        for (Key key : crowd.patch.binned().key) CHECK(crowd.owner_of(key, round) == crowd.comm.rank());
    }
}

TEST_CASE("what moved is counted, and nothing moves to where it is") {
    const Scene scene = test::periodic_scene(2, 5, 5, 1);
    Crowd<double, 2> crowd(MPI_COMM_WORLD, scene);
    settle(crowd, 1000, 20);
    const BlockMoveCount stay = crowd.shuffle(0);
    CHECK(stay.particles == 0);
    CHECK(stay.blocks == 0);
    const BinnedBlocks binned = crowd.patch.binned();
    std::int64_t blocks = 0, particles = 0;
    for (std::size_t b = 0; b < binned.key.size(); ++b) {
        if (crowd.owner_of(binned.key[b], 5) == crowd.comm.rank()) continue;
        ++blocks;
        particles += binned.count[b];
    }
    const BlockMoveCount moved = crowd.shuffle(5);
    CHECK(moved.blocks == blocks);
    CHECK(moved.particles == particles);
}

TEST_CASE("all blocks may go to one rank, and back; ranks may be left with nothing") {
    const Scene scene = test::periodic_scene(2, 4, 4, 1);
    Crowd<float, 2> crowd(MPI_COMM_WORLD, scene);
    settle(crowd, 500, 16);
    const auto before = crowd.rows();
    for (int owner = crowd.comm.size() - 1; owner >= 0; --owner) {
        const BinnedBlocks binned = crowd.patch.binned();
        BlockMoveCount moved;
        crowd.begin_epoch(
            move_blocks(crowd.comm, crowd.patch, binned, std::vector<std::int32_t>(binned.key.size(), owner), moved));
        CHECK(crowd.patch.count() == (crowd.comm.rank() == owner ? 500 : 0));
        CHECK(crowd.rows() == before);
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
