#include <doctest/doctest.h>

#include "records/plan_tiles.hpp"

using namespace moraine;

TEST_CASE("what ranks have of a tile comes together at its owner, and goes back to all that have it") {
    const Comm comm(MPI_COMM_WORLD);
    const auto n = static_cast<std::size_t>(PlanColumns::in_tile);
    std::vector<std::int64_t> numbers{1000003};  // all have this one
    for (std::int64_t t = comm.rank(); t < 40; t += comm.size()) numbers.push_back(t);
    const PlanTiles tiles(comm, numbers);
    REQUIRE(tiles.mine().size() == numbers.size());
    CHECK(comm.sum(static_cast<std::int64_t>(tiles.owned().size())) == 41);
    std::vector<std::int64_t> values;
    for (std::int64_t tile : tiles.mine())
        for (std::size_t k = 0; k < n; ++k) values.push_back(tile + static_cast<std::int64_t>(k));
    const auto all = tiles.add_up(values, 1, [](std::int64_t& to, std::int64_t value) { to += value; });
    for (std::size_t t = 0; t < tiles.owned().size(); ++t) {
        const std::int64_t tile = tiles.owned()[t];
        CHECK(owner_of_tile(tile, comm.size()) == comm.rank());
        CHECK(all[t * n + 7] == (tile + 7) * (tile == 1000003 ? comm.size() : 1));
    }
    const std::vector<std::int64_t> back = tiles.fetch(all);
    bool same = true;
    for (std::size_t t = 0; t < tiles.mine().size(); ++t)
        for (std::size_t k = 0; k < n; ++k)
            same = same && back[t * n + k] == values[t * n + k] * (tiles.mine()[t] == 1000003 ? comm.size() : 1);
    CHECK(same);
}

TEST_CASE("tiles side by side are shared among all ranks") {
    std::vector<int> count(7, 0);
    for (std::int64_t t = 0; t < 7000; ++t) ++count[static_cast<std::size_t>(owner_of_tile(t, 7))];
    for (int owned : count) CHECK(std::abs(owned - 1000) < 200);
}
