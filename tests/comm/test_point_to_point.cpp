// Buffers are filled with a pattern of (sender, receiver, exchange, place), so that a byte that comes
// from the wrong rank, exchange or place is seen. Bytes behind a message must stay as they were.

#include <doctest/doctest.h>

#include <vector>

#include "comm/point_to_point.hpp"
#include "core/data/hash.hpp"

using namespace moraine;

namespace {

constexpr auto untouched = std::byte{0xa5};

std::byte pattern(int from, int to, int exchange, std::int64_t at) {
    const auto word = static_cast<std::uint64_t>(at) << 24 ^ static_cast<std::uint64_t>(exchange) << 8 ^
                      static_cast<std::uint64_t>(from) << 4 ^ static_cast<std::uint64_t>(to);
    return static_cast<std::byte>(mix(word));
}

/// Bytes that travel in this exchange and the capacity that both sides know.
struct Length {
    std::int64_t bytes;
    std::int64_t capacity;
};

/// Starts an exchange with the given peers; length(from, to) is the same function on all ranks.
class Exchange {
  public:
    template <class F>
    Exchange(const Comm& comm, PointToPoint& messages, const std::vector<int>& peers, int number, const F& length)
        : me_(comm.rank()), messages_(messages), number_(number) {
        for (int peer : peers) {
            const Length out = length(me_, peer);
            const Length in = length(peer, me_);
            expected_.push_back(in.bytes);
            out_.emplace_back(static_cast<std::size_t>(out.capacity), untouched);
            for (std::int64_t k = 0; k < out.bytes; ++k)
                out_.back()[static_cast<std::size_t>(k)] = pattern(me_, peer, number, k);
            in_.emplace_back(static_cast<std::size_t>(in.capacity), untouched);
            sends_.push_back({peer, out_.back().data(), out.bytes, out.capacity});
            receives_.push_back({peer, in_.back().data(), -1, in.capacity});
        }
        messages.start(sends_, receives_);
    }

    void finish_and_check() {
        messages_.finish();
        for (std::size_t r = 0; r < receives_.size(); ++r) {
            REQUIRE(receives_[r].bytes == expected_[r]);
            bool same = true;
            for (std::size_t k = 0; k < in_[r].size(); ++k) {
                const bool sent = static_cast<std::int64_t>(k) < expected_[r];
                const auto at = static_cast<std::int64_t>(k);
                same = same && in_[r][k] == (sent ? pattern(receives_[r].peer, me_, number_, at) : untouched);
            }
            REQUIRE(same);
        }
    }

  private:
    int me_;
    PointToPoint& messages_;
    int number_;
    std::vector<std::int64_t> expected_;
    std::vector<std::vector<std::byte>> out_, in_;
    std::vector<Parcel> sends_, receives_;
};

std::vector<int> others(const Comm& comm) {
    std::vector<int> peers;
    for (int r = 0; r < comm.size(); ++r)
        if (r != comm.rank()) peers.push_back(r);
    return peers;
}

std::vector<int> ring(const Comm& comm) {
    std::vector<int> peers;
    const int n = comm.size();
    if (n > 1) peers.push_back((comm.rank() + 1) % n);
    if (n > 2) peers.push_back((comm.rank() + n - 1) % n);
    return peers;
}

}  // namespace

TEST_CASE("every byte comes to its place") {
    const Comm comm(MPI_COMM_WORLD);
    const auto once = [&](const std::vector<int>& peers, const auto& length) {
        PointToPoint messages(comm, 1);
        Exchange(comm, messages, peers, 0, length).finish_and_check();
    };
    SUBCASE("a ring of equal messages") {
        once(ring(comm), [](int, int) { return Length{1000, 1000}; });
    }
    SUBCASE("lengths that differ between pairs and directions") {
        once(others(comm), [](int from, int to) {
            const std::int64_t n = 1 + 977 * from + 13 * to;
            return Length{n, n};
        });
    }
    SUBCASE("messages that are shorter than their capacity, down to nothing") {
        once(others(comm), [](int from, int to) { return Length{from == 0 ? 0 : 100 * to, 5000}; });
    }
    SUBCASE("capacities of nothing") {
        once(others(comm), [](int from, int to) { return from < to ? Length{0, 0} : Length{8, 8}; });
    }
    SUBCASE("no peers at all") {
        once({}, [](int, int) { return Length{1, 1}; });
    }
    SUBCASE("messages of megabytes") {
        once(ring(comm), [](int from, int) { return Length{(3 << 20) + from, 4 << 20}; });
    }
    SUBCASE("many exchanges in a row over one tag do not mix") {
        PointToPoint messages(comm, 1);
        for (int n = 0; n < 200; ++n)
            Exchange(comm, messages, others(comm), n, [n](int from, int to) {
                return Length{(n * 37 + from * 11 + to) % 300, 300};
            }).finish_and_check();
    }
    SUBCASE("two of them are under way at once") {
        PointToPoint messages(comm, 1), other(comm, 2);
        for (int n = 0; n < 50; ++n) {
            Exchange first(comm, messages, others(comm), 2 * n, [](int, int) { return Length{500, 600}; });
            Exchange second(comm, other, ring(comm), 2 * n + 1, [](int, int) { return Length{90, 100}; });
            second.finish_and_check();
            first.finish_and_check();
        }
    }
}

TEST_CASE("bytes for each rank arrive at that rank, also those for itself and those that are none") {
    const Comm comm(MPI_COMM_WORLD);
    for (int n = 0; n < 20; ++n) {
        const auto length = [n](int from, int to) { return (from * 31 + to * 7 + n * 3) % 5 * 100; };
        std::vector<std::vector<std::byte>> to(static_cast<std::size_t>(comm.size()));
        for (int r = 0; r < comm.size(); ++r)
            for (int k = 0; k < length(comm.rank(), r); ++k)
                to[static_cast<std::size_t>(r)].push_back(pattern(comm.rank(), r, n, k));
        const std::vector<std::vector<std::byte>> come = exchange_all(comm, to);
        REQUIRE(come.size() == to.size());
        for (int r = 0; r < comm.size(); ++r) {
            const auto& from = come[static_cast<std::size_t>(r)];
            REQUIRE(from.size() == static_cast<std::size_t>(length(r, comm.rank())));
            bool same = true;
            for (std::size_t k = 0; k < from.size(); ++k)
                same = same && from[k] == pattern(r, comm.rank(), n, static_cast<std::int64_t>(k));
            REQUIRE(same);
        }
    }
}
