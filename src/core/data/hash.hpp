#pragma once
// Hash of a run's state: the sum modulo 2^64 of a strong hash of each particle's (id, full state).
//
// A sum does not depend on who adds what, so equal states have equal hashes on any number of ranks.
// The mixing is that of splitmix64 (Steele, Lea, Flood 2014), word by word.

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace moraine {

constexpr std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}

/// Continues hash h with the bytes of one value.
inline std::uint64_t mix_bytes(std::uint64_t h, const std::byte* data, std::size_t bytes) {
    while (bytes > 0) {
        std::uint64_t word = 0;
        const std::size_t n = bytes < 8 ? bytes : 8;
        std::memcpy(&word, data, n);
        h = mix(h ^ mix(word));
        data += n;
        bytes -= n;
    }
    return h;
}

}  // namespace moraine
