#pragma once
// A particle as it travels between devices: a record of units of 16 bytes. The first unit says what it is and where it
// goes, the others are its rows (gpu/memory/particle_rows.hpp), all that the scene has.

#include <vector_types.h>

#include <cstdint>
#include <vector>

#include "gpu/memory/particle_rows.hpp"

namespace moraine::gpu {

struct alignas(16) RecordHead {
    std::uint64_t id;
    std::uint16_t body;
    std::uint8_t exit;   ///< walked: the exit of the source block that it took
    std::uint8_t cell;   ///< walked: cell in the next block
    std::uint32_t tile;  ///< walked: number of the source block in the peer's list
};
static_assert(sizeof(RecordHead) == 16);

/// Where the units of a record come from and go to. Passed to kernels by value.
struct RecordLayout {
    static constexpr int most_rows = 10;
    std::uint64_t* id;
    std::uint16_t* body;
    uint4* row[most_rows];
    int rows;
    int row_units;     ///< of 16 bytes
    void* scalar;      ///< null: none
    int scalar_bytes;  ///< 4 or 8
    int units;         ///< of a record

    std::size_t bytes() const { return static_cast<std::size_t>(units) * 16; }
};

template <class Real, int Dim>
RecordLayout record_layout(const Columns<Real, Dim>& columns) {
    RecordLayout r{};
    r.id = columns.id;
    r.body = columns.body;
    const auto add = [&](Row<Real>* row) {
        if (row) r.row[r.rows++] = reinterpret_cast<uint4*>(row);
    };
    for (Row<Real>* row : columns.core) add(row);
    for (Row<Real>* row : columns.affine) add(row);
    for (Row<Real>* row : columns.stretch) add(row);
    add(columns.log_stretch);
    r.row_units = sizeof(Row<Real>) / 16;
    r.scalar = columns.second_history;
    r.scalar_bytes = sizeof(Real);
    r.units = 1 + r.rows * r.row_units + (r.scalar ? 1 : 0);
    return r;
}

}  // namespace moraine::gpu
