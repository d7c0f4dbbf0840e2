#pragma once
// Units of a record to and from memory (gpu/exchange/particle_record.hpp).

#include "gpu/exchange/particle_record.hpp"

namespace moraine::gpu {

/// Unit u > 0 of the particle in a slot.
__device__ __forceinline__ uint4 record_unit(const RecordLayout& r, int u, std::uint32_t slot) {
    const int k = (u - 1) / r.row_units, part = (u - 1) % r.row_units;
    if (k < r.rows) return r.row[k][std::size_t(slot) * r.row_units + part];
    const void* scalar = r.scalar[u - 1 - r.rows * r.row_units];
    uint4 unit{};
    if (r.scalar_bytes == 4) {
        unit.x = static_cast<const std::uint32_t*>(scalar)[slot];
    } else {
        const std::uint64_t bits = static_cast<const std::uint64_t*>(scalar)[slot];
        unit.x = static_cast<std::uint32_t>(bits), unit.y = static_cast<std::uint32_t>(bits >> 32);
    }
    return unit;
}

/// Puts unit u of a record into a slot.
__device__ __forceinline__ void set_record_unit(const RecordLayout& r, int u, std::uint32_t slot, const uint4& unit) {
    if (u == 0) {
        RecordHead head;
        memcpy(&head, &unit, sizeof(head));
        r.id[slot] = head.id;
        r.body[slot] = head.body;
        return;
    }
    const int k = (u - 1) / r.row_units, part = (u - 1) % r.row_units;
    if (k < r.rows) {
        r.row[k][std::size_t(slot) * r.row_units + part] = unit;
        return;
    }
    void* scalar = r.scalar[u - 1 - r.rows * r.row_units];
    if (r.scalar_bytes == 4)
        static_cast<std::uint32_t*>(scalar)[slot] = unit.x;
    else
        static_cast<std::uint64_t*>(scalar)[slot] = unit.x | std::uint64_t(unit.y) << 32;
}

}  // namespace moraine::gpu
