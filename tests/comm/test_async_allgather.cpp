#include <doctest/doctest.h>

#include "comm/async_allgather.hpp"

using namespace moraine;

namespace {

struct Row {
    std::int64_t rank, number;
    bool operator==(const Row&) const = default;
};

/// Rank r has `most` - r rows, or none.
std::vector<Row> rows_of(int rank, int most) {
    std::vector<Row> rows;
    for (int i = 0; i < most - rank; ++i) rows.push_back({rank, i});
    return rows;
}

}  // namespace

TEST_CASE("a gather in parts brings what one at once brings, however the other messages go between") {
    const Comm comm(MPI_COMM_WORLD);
    AsyncAllgather<Row> gather(comm);
    for (int most : {0, 1, 2, 5000}) {
        CAPTURE(most);
        CHECK_FALSE(gather.under_way());
        gather.start(rows_of(comm.rank(), most));
        CHECK(gather.under_way());
        CHECK(comm.sum(std::int64_t(1)) == comm.size());
        CHECK_FALSE(gather.advance().has_value());
        std::vector<std::int64_t> counts;
        const std::vector<Row> at_once = comm.all_gather(rows_of(comm.rank(), most), &counts);
        const auto all = gather.advance();
        REQUIRE(all.has_value());
        CHECK(all->rows == at_once);
        CHECK(all->counts == counts);
    }
}

TEST_CASE("a gather ends at once where it is wanted now, and nothing comes of none") {
    const Comm comm(MPI_COMM_WORLD);
    AsyncAllgather<Row> gather(comm);
    CHECK_FALSE(gather.finish().has_value());
    for (int parts : {0, 1}) {
        gather.start(rows_of(comm.rank(), 7));
        for (int k = 0; k < parts; ++k) CHECK_FALSE(gather.advance().has_value());
        const auto all = gather.finish();
        REQUIRE(all.has_value());
        CHECK(all->rows.size() == static_cast<std::size_t>(comm.sum(std::int64_t(std::max(0, 7 - comm.rank())))));
        CHECK_FALSE(gather.under_way());
    }
}
