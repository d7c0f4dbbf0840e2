#pragma once
// What every wire must do. A wire's test includes this and calls conforms(comm, make_wire), where
// make_wire(tag) gives an owning pointer to a Transport.
//
// Buffers are filled with a pattern of (sender, receiver, exchange, place), so that a byte that comes
// from the wrong rank, exchange or place is seen. Bytes behind a message must stay as they were.

#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "comm/point_to_point.hpp"
#include "core/hash.hpp"

namespace moraine::test {

inline constexpr auto untouched = std::byte{0xa5};

inline std::byte pattern(int from, int to, int exchange, std::int64_t at) {
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
    Exchange(const Comm& comm, Transport& wire, const std::vector<int>& peers, int number, const F& length)
        : me_(comm.rank()), wire_(wire), number_(number) {
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
        wire.start(sends_, receives_);
    }

    void finish_and_check() {
        wire_.finish();
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
    Transport& wire_;
    int number_;
    std::vector<std::int64_t> expected_;
    std::vector<std::vector<std::byte>> out_, in_;
    std::vector<Parcel> sends_, receives_;
};

inline std::vector<int> others(const Comm& comm) {
    std::vector<int> peers;
    for (int r = 0; r < comm.size(); ++r)
        if (r != comm.rank()) peers.push_back(r);
    return peers;
}

inline std::vector<int> ring(const Comm& comm) {
    std::vector<int> peers;
    const int n = comm.size();
    if (n > 1) peers.push_back((comm.rank() + 1) % n);
    if (n > 2) peers.push_back((comm.rank() + n - 1) % n);
    return peers;
}

template <class MakeWire>
void conforms(const Comm& comm, const MakeWire& make_wire) {
    const auto once = [&](const std::vector<int>& peers, const auto& length) {
        const std::unique_ptr<Transport> wire = make_wire(1);
        Exchange(comm, *wire, peers, 0, length).finish_and_check();
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
    SUBCASE("many exchanges in a row over one wire do not mix") {
        const std::unique_ptr<Transport> wire = make_wire(1);
        for (int n = 0; n < 200; ++n)
            Exchange(comm, *wire, others(comm), n, [n](int from, int to) {
                return Length{(n * 37 + from * 11 + to) % 300, 300};
            }).finish_and_check();
    }
    SUBCASE("two wires are under way at once") {
        const std::unique_ptr<Transport> wire = make_wire(1), other = make_wire(2);
        for (int n = 0; n < 50; ++n) {
            Exchange first(comm, *wire, others(comm), 2 * n, [](int, int) { return Length{500, 600}; });
            Exchange second(comm, *other, ring(comm), 2 * n + 1, [](int, int) { return Length{90, 100}; });
            second.finish_and_check();
            first.finish_and_check();
        }
    }
}

}  // namespace moraine::test
