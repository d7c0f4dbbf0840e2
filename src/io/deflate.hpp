#pragma once
// Compression of chunks by filters that the HDF5 library has by itself, so that every reader of it reads them: the
// bytes of the numbers are sorted (all first bytes, all second ones, ...), then deflated (RFC 1950). Signs, exponents
// and leading digits of neighbours along the curve are alike; the last digits are noise, and stay.

#include <cstddef>
#include <span>
#include <vector>

namespace moraine {

inline constexpr int deflate_level = 1;

/// Whether the program was built with zlib.
bool can_deflate();

/// `bytes`: whole numbers of `number_bytes` each. Throws MachineError where it cannot. Not collective.
std::vector<std::byte> deflated(std::span<const std::byte> bytes, std::size_t number_bytes);

}  // namespace moraine
