#include <doctest/doctest.h>

#include <bit>
#include <set>
#include <vector>

#include "core/data/hash.hpp"

using namespace moraine;

namespace {

std::uint64_t hash_of(const std::vector<unsigned char>& bytes) {
    return mix_bytes(1, reinterpret_cast<const std::byte*>(bytes.data()), bytes.size());
}

}  // namespace

TEST_CASE("the mixing is that of splitmix64") {
    CHECK(mix(0) == 0xe220a8397b1dcdafULL);
    CHECK(mix(0x9e3779b97f4a7c15ULL) == 0x6e789e6aa1b965f4ULL);
    CHECK(mix(2 * 0x9e3779b97f4a7c15ULL) == 0x06c45d188009454fULL);
}

TEST_CASE("neighbouring numbers have different hashes that differ in half of their bits") {
    std::set<std::uint64_t> seen;
    double bits = 0;
    for (std::uint64_t k = 0; k < 100000; ++k) {
        seen.insert(mix(k));
        bits += std::popcount(mix(k) ^ mix(k + 1));
    }
    CHECK(seen.size() == 100000);
    CHECK(bits / 100000 == doctest::Approx(32).epsilon(0.01));
}

TEST_CASE("every bit of every byte counts, in words and in the tail") {
    for (std::size_t length : {1u, 2u, 4u, 7u, 8u, 12u, 16u, 23u}) {
        std::vector<unsigned char> bytes(length, 0x5a);
        const std::uint64_t plain = hash_of(bytes);
        std::set<std::uint64_t> seen{plain};
        for (std::size_t b = 0; b < 8 * length; ++b) {
            bytes[b / 8] = static_cast<unsigned char>(bytes[b / 8] ^ (1u << b % 8));
            seen.insert(hash_of(bytes));
            bytes[b / 8] = static_cast<unsigned char>(bytes[b / 8] ^ (1u << b % 8));
        }
        CHECK(seen.size() == 8 * length + 1);
        CHECK(hash_of(bytes) == plain);
    }
}

TEST_CASE("the order of words and the hash so far count") {
    std::vector<unsigned char> one(16, 1);
    std::fill_n(one.begin(), 8, static_cast<unsigned char>(2));
    std::vector<unsigned char> other(16, 2);
    std::fill_n(other.begin(), 8, static_cast<unsigned char>(1));
    CHECK(hash_of(one) != hash_of(other));
    const auto* data = reinterpret_cast<const std::byte*>(one.data());
    CHECK(mix_bytes(1, data, 16) != mix_bytes(2, data, 16));
    CHECK(mix_bytes(7, data, 0) == 7);
}
