#pragma once
// Rows of particles as bytes: gathered from slots into a message or file, and back.
//
// Column after column, each padded to 8 bytes, in the order of Particles::columns().

#include <cstring>
#include <span>

#include "core/particles/particles.hpp"

namespace moraine {

inline std::size_t padded(std::size_t bytes) {
    return (bytes + 7) / 8 * 8;
}

inline std::size_t rows_bytes(const std::vector<ColumnBytes>& columns, std::size_t rows) {
    std::size_t sum = 0;
    for (const ColumnBytes& c : columns) sum += padded(c.row_bytes * rows);
    return sum;
}

/// Copies one column's rows at `slots` to `to`.
inline void pack_column(const ColumnBytes& c, std::span<const std::uint32_t> slots, std::byte* to) {
    for (std::size_t k = 0; k < slots.size(); ++k)
        std::memcpy(to + k * c.row_bytes, c.data + slots[k] * c.row_bytes, c.row_bytes);
}

/// Copies the rows at `slots` to `to`; returns the end.
inline std::byte* pack_rows(const std::vector<ColumnBytes>& columns, std::span<const std::uint32_t> slots,
                            std::byte* to) {
    for (const ColumnBytes& c : columns) {
        pack_column(c, slots, to);
        to += padded(c.row_bytes * slots.size());
    }
    return to;
}

/// Inverse of pack_rows; returns the end.
inline const std::byte* unpack_rows(const std::vector<ColumnBytes>& columns, std::span<const std::uint32_t> slots,
                                    const std::byte* from) {
    for (const ColumnBytes& c : columns) {
        for (std::size_t k = 0; k < slots.size(); ++k)
            std::memcpy(c.data + slots[k] * c.row_bytes, from + k * c.row_bytes, c.row_bytes);
        from += padded(c.row_bytes * slots.size());
    }
    return from;
}

}  // namespace moraine
