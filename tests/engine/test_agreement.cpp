#include <doctest/doctest.h>

#include "engine/agreement.hpp"

using namespace moraine;

TEST_CASE("all ranks learn the largest, the sums and every fault and request") {
    const Comm comm(MPI_COMM_WORLD);
    AgreementReduction reduction(comm);
    const int n = comm.size();
    for (int round = 0; round < 20; ++round) {
        const int r = (comm.rank() + round) % n;  // another rank is the largest each time
        Agreement mine;
        mine.signal = 10.5 + r;
        mine.moved = 0.25 / (1 + r);
        mine.seconds = 0.5 * (r + 1);
        mine.seconds_sum = 1e9;  // overwritten
        mine.count = (std::int64_t(1) << 40) + r;
        mine.blocks = 100 + r;
        mine.migration_bound = {7 - r, 1000 + r};
        mine.making = r == 0 ? 1u : 0u;
        mine.faults = 1u << r;
        mine.stop = r == n - 1 ? 2u : 0u;
        reduction.start(mine);
        const Agreement all = reduction.finish();
        CHECK(all.signal == 10.5 + n - 1);
        CHECK(all.moved == 0.25);
        CHECK(all.seconds == 0.5 * n);
        CHECK(all.seconds_sum == 0.25 * n * (n + 1));
        CHECK(all.count == (std::int64_t(1) << 40) + n - 1);
        CHECK(all.count_sum == n * (std::int64_t(1) << 40) + n * (n - 1) / 2);
        CHECK(all.blocks == 100 * n + n * (n - 1) / 2);
        CHECK(all.migration_bound.block == 7);
        CHECK(all.migration_bound.pair == 1000 + n - 1);
        CHECK(all.making == 1);
        CHECK(all.faults == (1u << n) - 1);
        CHECK(all.stop == 2);
    }
}

TEST_CASE("a rank without particles takes nothing from the others") {
    const Comm comm(MPI_COMM_WORLD);
    AgreementReduction reduction(comm);
    Agreement mine;
    if (comm.is_root()) mine.signal = 3, mine.count = 7;
    reduction.start(mine);
    const Agreement all = reduction.finish();
    CHECK(all.signal == 3);
    CHECK(all.count == 7);
    CHECK(all.count_sum == 7);
    CHECK(all.making == 0);
    CHECK(all.faults == 0);
    CHECK(all.stop == 0);
}

TEST_CASE("the caller may change its numbers while the reduction is under way") {
    const Comm comm(MPI_COMM_WORLD);
    AgreementReduction reduction(comm);
    Agreement mine;
    mine.signal = comm.rank();
    reduction.start(mine);
    mine.signal = 1e9;
    CHECK(reduction.finish().signal == comm.size() - 1);
}
