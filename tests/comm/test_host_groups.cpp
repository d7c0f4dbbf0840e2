#include <doctest/doctest.h>

#include <cstdlib>
#include <string>

#include "comm/host_groups.hpp"
#include "core/data/error.hpp"

using namespace moraine;

namespace {

HostOfRank pretend(const Comm& comm, const char* hosts) {
    setenv("MORAINE_PRETEND_HOSTS", hosts, 1);
    try {
        const HostOfRank found = find_hosts(comm);
        unsetenv("MORAINE_PRETEND_HOSTS");
        return found;
    } catch (...) {
        unsetenv("MORAINE_PRETEND_HOSTS");
        throw;
    }
}

}  // namespace

TEST_CASE("the ranks of this machine are on one host") {
    const Comm comm(MPI_COMM_WORLD);
    unsetenv("MORAINE_PRETEND_HOSTS");
    CHECK(find_hosts(comm) == HostOfRank(static_cast<std::size_t>(comm.size()), 0));
}

TEST_CASE("pretended hosts have ranks in a row, nearly as many each, and at least one") {
    const Comm comm(MPI_COMM_WORLD);
    const HostOfRank wanted[] = {{0}, {0, 1}, {0, 0, 1}, {0, 0, 1, 1}};
    CHECK(pretend(comm, "2") == wanted[comm.size() - 1]);
    CHECK(host_count(pretend(comm, "100")) == comm.size());
    CHECK(host_count(pretend(comm, "1")) == 1);
}

TEST_CASE("pretended hosts of each rank are numbered by their lowest ranks") {
    const Comm comm(MPI_COMM_WORLD);
    HostOfRank wanted{0, 1, 0, 2};
    wanted.resize(static_cast<std::size_t>(comm.size()));
    CHECK(pretend(comm, "7,3,7,0,12") == wanted);
    if (comm.size() > 2) CHECK_THROWS_AS(pretend(comm, "0,1"), InputError);
}

TEST_CASE("a number of hosts that is none is refused on all ranks, also if rank 0 alone was told it") {
    const Comm comm(MPI_COMM_WORLD);
    for (const char* words : {"0", "-2", "two", "2x", "1e3", "99999999999999999999", "0,1,", ",0", "0,,1", "0,-1"}) {
        CAPTURE(words);
        CHECK_THROWS_AS(pretend(comm, comm.is_root() ? words : ""), InputError);
    }
}

TEST_CASE("hosts of a replay have so many ranks each, and none means one host") {
    CHECK(hosts_of(5, 2) == HostOfRank{0, 0, 1, 1, 2});
    CHECK(host_count(hosts_of(5, 2)) == 3);
    CHECK(hosts_of(3, 0) == HostOfRank{0, 0, 0});
    CHECK(host_count({}) == 1);
}
