#pragma once
// Units of a record to and from memory (gpu/exchange/particle_record.hpp).

#include "gpu/exchange/particle_record.hpp"

namespace moraine::gpu {

__device__ __forceinline__ uint4 unit_of(std::uint64_t low, std::uint64_t high) {
    return {static_cast<std::uint32_t>(low), static_cast<std::uint32_t>(low >> 32), static_cast<std::uint32_t>(high),
            static_cast<std::uint32_t>(high >> 32)};
}

/// Unit u > 0 of the particle in a slot.
__device__ __forceinline__ uint4 record_unit(const RecordLayout& r, int u, std::uint32_t slot) {
    const int k = (u - 1) / r.row_units, part = (u - 1) % r.row_units;
    if (k < r.rows) return r.row[k][std::size_t(slot) * r.row_units + part];
    const int number = u - 1 - r.rows * r.row_units;
    if (number == r.scalars) return unit_of(r.rest.place[slot], r.rest.stress[slot]);
    const void* scalar = r.scalar[number];
    uint4 unit{};
    if (r.scalar_bytes == 4) {
        unit.x = static_cast<const std::uint32_t*>(scalar)[slot];
    } else {
        unit = unit_of(static_cast<const std::uint64_t*>(scalar)[slot], 0);
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
    const int number = u - 1 - r.rows * r.row_units;
    const std::uint64_t low = unit.x | std::uint64_t(unit.y) << 32;
    if (number == r.scalars) {
        r.rest.place[slot] = low;
        r.rest.stress[slot] = unit.z | std::uint64_t(unit.w) << 32;
    } else if (r.scalar_bytes == 4) {
        static_cast<std::uint32_t*>(r.scalar[number])[slot] = unit.x;
    } else {
        static_cast<std::uint64_t*>(r.scalar[number])[slot] = low;
    }
}

}  // namespace moraine::gpu
