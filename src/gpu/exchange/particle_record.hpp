#pragma once
// A particle as it travels between devices: a record of units of 16 bytes. The first unit says what it is and where it
// goes, the others are its rows (gpu/memory/particle_rows.hpp), all that the scene has, and the words of sleep.

#include <vector_types.h>

#include <cstdint>
#include <vector>

#include "gpu/memory/particle_rows.hpp"
#include "gpu/memory/rest_words.hpp"

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
    static constexpr int most_rows = all_rows<3>, most_scalars = own_columns<3>();
    std::uint64_t* id;
    std::uint16_t* body;
    uint4* row[most_rows];
    int rows;
    int row_units;               ///< of 16 bytes
    void* scalar[most_scalars];  ///< columns of scalars, a unit each
    int scalars;
    int scalar_bytes;  ///< 4 or 8
    RestWords rest;    ///< the last unit, where there are any
    int units;         ///< of a record

    std::size_t bytes() const { return static_cast<std::size_t>(units) * 16; }
};

template <class Real, int Dim>
RecordLayout record_layout(Columns<Real, Dim> columns, const RestWords& rest = {}) {
    RecordLayout r{};
    r.id = columns.id;
    r.body = columns.body;
    each_row_of<Dim>([&](RowGroup group, int k, int) {
        if (Row<Real>* row = columns.row(group, k)) r.row[r.rows++] = reinterpret_cast<uint4*>(row);
    });
    for (Real* column : columns.own)
        if (column) r.scalar[r.scalars++] = column;
    r.row_units = sizeof(Row<Real>) / 16;
    r.scalar_bytes = sizeof(Real);
    r.rest = rest;
    r.units = 1 + r.rows * r.row_units + r.scalars + (rest.place ? 1 : 0);
    return r;
}

static_assert(all_rows<2> <= RecordLayout::most_rows && own_columns<2>() <= RecordLayout::most_scalars);

}  // namespace moraine::gpu
