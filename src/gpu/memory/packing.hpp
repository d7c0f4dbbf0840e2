#pragma once
// Rows on the device to and from columns as the host keeps them (core/particles/particles.hpp): for output,
// checkpoints, messages and the start of a run.
//
// A host column is made of at most three parts: consecutive lanes of a column of rows. pack_rows() puts a part's
// lanes of the particles in given slots into a contiguous buffer of the host's format; unpack_rows() is its inverse.

#include <cuda_runtime.h>

#include <string_view>
#include <vector>

#include "gpu/memory/particle_rows.hpp"

namespace moraine::gpu {

/// Entry k has scalars k stride ... of the host's column; those from `offset` on are the lanes from `lane` on of the
/// row of `row` scalars of its slot.
struct RowPart {
    void* rows;
    int scalar_bytes;  ///< 2, 4 or 8
    int row;
    int lane;
    int lanes;
    int stride;
    int offset;
};

void pack_rows(std::uint32_t n, const std::uint32_t* slot, const RowPart& part, void* packed, cudaStream_t stream);
void unpack_rows(std::uint32_t n, const std::uint32_t* slot, const RowPart& part, const void* packed,
                 cudaStream_t stream);

/// A variable's own column on the device; null: it has none, or the scene has not.
template <class Real, int Dim>
void* own_column(const Columns<Real, Dim>& columns, std::string_view name) {
    if (name == "id") return columns.id;
    if (name == "body") return columns.body;
    void* found = nullptr;
    each_own_column<Dim>([&](const auto& variable, int k) {
        if (name == variable.name) found = columns.own[k];
    });
    return found;
}

/// The host's columns by name (Particles::columns()) in terms of rows; none: the device has no such column.
template <class Real, int Dim>
std::vector<RowPart> parts_of(Columns<Real, Dim> columns, std::string_view name) {
    std::vector<RowPart> parts;
    each_variable<Real, Dim>([&](const auto& v) {
        if (name != v.name) return;
        const int scalar = static_cast<int>(v.scalar_bytes), components = v.components();
        for (const RowPlace& p : v.places)
            if (Row<Real>* rows = p.lanes > 0 ? columns.row(p.group, p.row) : nullptr)
                parts.push_back({rows, scalar, 4, p.lane, p.lanes, components, p.first});
        if (void* own = own_column(columns, name)) parts.push_back({own, scalar, 1, 0, components, components, 0});
    });
    return parts;
}

}  // namespace moraine::gpu
