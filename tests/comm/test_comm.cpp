#include <doctest/doctest.h>

#include "comm/comm.hpp"
#include "core/data/error.hpp"
#include "core/data/exact_sum.hpp"

using namespace moraine;

TEST_CASE("rows of unequal numbers arrive rank by rank") {
    const Comm comm(MPI_COMM_WORLD);
    struct Row {
        std::int32_t rank;
        double value;
    };
    std::vector<Row> mine;
    for (int k = 0; k < 3 * comm.rank(); ++k) mine.push_back({comm.rank(), k + 0.5});  // rank 0 has none
    std::vector<std::int64_t> counts;
    const std::vector<Row> all = comm.all_gather(mine, &counts);
    REQUIRE(counts.size() == static_cast<std::size_t>(comm.size()));
    std::size_t at = 0;
    for (int r = 0; r < comm.size(); ++r) {
        CHECK(counts[static_cast<std::size_t>(r)] == 3 * r);
        for (int k = 0; k < 3 * r; ++k, ++at) {
            REQUIRE(all[at].rank == r);
            REQUIRE(all[at].value == k + 0.5);
        }
    }
    CHECK(all.size() == at);
}

TEST_CASE("reductions are over all ranks") {
    const Comm comm(MPI_COMM_WORLD);
    const int n = comm.size();
    CHECK(comm.min(comm.rank() + 1.5) == 1.5);
    CHECK(comm.max(-comm.rank() - 1.5) == -1.5);
    CHECK(comm.sum(comm.rank() + 1.0) == n * (n + 1) / 2);
    CHECK(comm.max(std::int64_t(comm.rank())) == n - 1);
    CHECK(comm.sum(std::int64_t(1) << 40) == std::int64_t(n) << 40);
    std::vector<std::int64_t> values{comm.rank(), 1, -comm.rank()};
    comm.sum(values);
    CHECK(values[0] == n * (n - 1) / 2);
    CHECK(values[1] == n);
    CHECK(values[2] == -n * (n - 1) / 2);
}

TEST_CASE("sums of whole numbers wrap around, and exact sums carry") {
    const Comm comm(MPI_COMM_WORLD);
    const auto n = static_cast<std::uint64_t>(comm.size());
    CHECK(comm.sum(~std::uint64_t(0)) == std::uint64_t(0) - n);
    const ExactSum largest{0, ~std::uint64_t(0)};
    const std::vector<ExactSum> sums = comm.exact_sums(std::vector<ExactSum>{largest, {comm.rank(), 0}});
    REQUIRE(sums.size() == 2);
    CHECK(sums[0].high == comm.size() - 1);
    CHECK(sums[0].low == std::uint64_t(0) - n);
    CHECK(sums[1].high == comm.size() * (comm.size() - 1) / 2);
    CHECK(comm.exact_sum(largest).high == sums[0].high);
    CHECK(comm.exact_sums(std::vector<ExactSum>{}).empty());
}

TEST_CASE("words of any rank reach all ranks") {
    const Comm comm(MPI_COMM_WORLD);
    for (int root = 0; root < comm.size(); ++root) {
        const std::string message = "from " + std::to_string(root);
        CHECK(comm.broadcast(comm.rank() == root ? message : "nothing", root) == message);
        CHECK(comm.broadcast(comm.rank() == root ? "" : "something", root).empty());
    }
}

TEST_CASE("an error of any rank is thrown by every rank in the words of the lowest one") {
    const Comm comm(MPI_COMM_WORLD);
    CHECK_NOTHROW(comm.agree_no_error<InputError>(""));
    const int last = comm.size() - 1;
    CHECK_THROWS_WITH_AS(comm.agree_no_error<InputError>(comm.rank() == last ? "bad" : ""), "bad", InputError);
    const std::string lowest = "rank " + std::to_string(last / 2);
    CHECK_THROWS_WITH_AS(
        comm.agree_no_error<MachineError>(comm.rank() < last / 2 ? "" : "rank " + std::to_string(comm.rank())),
        lowest.c_str(), MachineError);
}

TEST_CASE("messages of a duplicate cannot meet those of its parent") {
    const Comm one(MPI_COMM_WORLD), other(MPI_COMM_WORLD);
    int compared = MPI_UNEQUAL;
    MPI_Comm_compare(one.handle(), other.handle(), &compared);
    CHECK(compared == MPI_CONGRUENT);
    CHECK(one.is_root() == (one.rank() == 0));
}
