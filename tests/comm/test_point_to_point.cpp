#include "comm/point_to_point.hpp"
#include "comm/transport_conformance.hpp"

using namespace moraine;

TEST_CASE("the host wire brings every byte to its place") {
    const Comm comm(MPI_COMM_WORLD);
    test::conforms(comm, [&](int tag) { return std::make_unique<HostTransport>(comm, tag); });
}

TEST_CASE("bytes for each rank arrive at that rank, also those for itself and those that are none") {
    const Comm comm(MPI_COMM_WORLD);
    for (int n = 0; n < 20; ++n) {
        const auto length = [n](int from, int to) { return (from * 31 + to * 7 + n * 3) % 5 * 100; };
        std::vector<std::vector<std::byte>> to(static_cast<std::size_t>(comm.size()));
        for (int r = 0; r < comm.size(); ++r)
            for (int k = 0; k < length(comm.rank(), r); ++k)
                to[static_cast<std::size_t>(r)].push_back(test::pattern(comm.rank(), r, n, k));
        const std::vector<std::vector<std::byte>> come = exchange_all(comm, to);
        REQUIRE(come.size() == to.size());
        for (int r = 0; r < comm.size(); ++r) {
            const auto& from = come[static_cast<std::size_t>(r)];
            REQUIRE(from.size() == static_cast<std::size_t>(length(r, comm.rank())));
            bool same = true;
            for (std::size_t k = 0; k < from.size(); ++k)
                same = same && from[k] == test::pattern(r, comm.rank(), n, static_cast<std::int64_t>(k));
            REQUIRE(same);
        }
    }
}
