#include <doctest/doctest.h>

#include "comm/host_groups.hpp"
#include "comm/host_routes.hpp"
#include "comm/point_to_point.hpp"

using namespace moraine;

namespace {

/// All ways in which ranks can share hosts, numbered by lowest ranks.
std::vector<HostOfRank> all_hosts(int ranks) {
    std::vector<HostOfRank> all{{0}};
    for (int r = 1; r < ranks; ++r) {
        std::vector<HostOfRank> longer;
        for (const HostOfRank& host : all)
            for (std::int32_t h = 0; h <= host_count(host); ++h) {
                longer.push_back(host);
                longer.back().push_back(h);
            }
        all = std::move(longer);
    }
    return all;
}

/// Messages of one exchange, by communicator.
struct Messages {
    std::vector<std::int64_t> out, in;
    std::vector<Parcel> sends, receives;

    explicit Messages(std::size_t ranks) : out(ranks), in(ranks, -1) {}
    void add(std::size_t rank, int number, std::int64_t word) {
        out[rank] = word;
        sends.push_back({number, reinterpret_cast<std::byte*>(&out[rank]), 8, 8});
        receives.push_back({number, reinterpret_cast<std::byte*>(&in[rank]), 0, 8});
    }
};

}  // namespace

TEST_CASE("ranks of a host are numbered by rank among themselves, and both sides of a pair take the same way") {
    for (const HostOfRank& host : all_hosts(5)) {
        std::vector<std::vector<std::int32_t>> number;
        for (int r = 0; r < 5; ++r) number.push_back(numbers_on_host(host, r));
        for (std::size_t a = 0; a < 5; ++a)
            for (std::size_t b = 0; b < 5; ++b) {
                REQUIRE((number[a][b] >= 0) == (host[a] == host[b]));
                REQUIRE((number[a][b] >= 0) == (number[b][a] >= 0));
                if (host[a] != host[b]) continue;
                REQUIRE(number[a] == number[b]);
                REQUIRE((a < b) == (number[a][a] < number[a][b]));
            }
    }
}

TEST_CASE("one round of messages, within hosts by their own communicators and between by that of all, arrives whole") {
    const Comm comm(MPI_COMM_WORLD);
    const auto ranks = static_cast<std::size_t>(comm.size());
    for (const HostOfRank& host : all_hosts(comm.size())) {
        const std::unique_ptr<const Comm> here = ranks_of_host(comm, host);
        const std::vector<std::int32_t> number = numbers_on_host(host, comm.rank());
        CHECK(number[static_cast<std::size_t>(comm.rank())] == here->rank());
        Messages within(ranks), between(ranks);
        for (std::size_t r = 0; r < ranks; ++r) {
            const std::int64_t word = 100 * comm.rank() + static_cast<std::int64_t>(r);
            if (static_cast<int>(r) == comm.rank()) continue;
            if (number[r] >= 0)
                within.add(r, number[r], word);
            else
                between.add(r, static_cast<int>(r), word);
        }
        CHECK(static_cast<int>(within.sends.size()) == here->size() - 1);
        PointToPoint near(*here, 5), far(comm, 5);
        near.start(within.sends, within.receives);
        far.start(between.sends, between.receives);
        far.finish();
        near.finish();
        for (std::size_t r = 0; r < ranks; ++r)
            if (static_cast<int>(r) != comm.rank())
                CHECK((number[r] >= 0 ? within : between).in[r] == 100 * static_cast<std::int64_t>(r) + comm.rank());
    }
}
