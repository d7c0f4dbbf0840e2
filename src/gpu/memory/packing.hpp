#pragma once
// Rows on the device to and from columns as the host keeps them (core/particles.hpp): for output, checkpoints,
// messages and the start of a run.
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

/// The host's columns by name (Particles::columns()) in terms of rows; none: the device has no such column.
template <class Real, int Dim>
std::vector<RowPart> parts_of(const Columns<Real, Dim>& columns, std::string_view name) {
    using Core = CoreRows<Real, Dim>;
    constexpr int size = sizeof(Real);
    const auto lanes = [](Row<Real>* rows, int lane, int count, int stride, int offset = 0) {
        return rows ? std::vector<RowPart>{{rows, size, 4, lane, count, stride, offset}} : std::vector<RowPart>{};
    };
    /// A symmetric tensor in one row of four, or in two of three.
    const auto tensor = [&](Row<Real>* normal, Row<Real>* shear) {
        if (Dim == 2) return lanes(normal, 0, 4, 4);
        std::vector<RowPart> both = lanes(normal, 0, 3, 6);
        if (shear) both.push_back(lanes(shear, 0, 3, 6, 3).front());
        return both;
    };
    if (name == "id") return {{columns.id, 8, 1, 0, 1, 1, 0}};
    if (name == "body") return {{columns.body, 2, 1, 0, 1, 1, 0}};
    if (name == "position") return lanes(columns.core[Core::place], 0, Dim, Dim);
    if (name == "mass") return lanes(columns.core[Core::place], Dim, 1, 1);
    if (name == "velocity") return lanes(columns.core[Core::motion], 0, Dim, Dim);
    if (name == "volume") return lanes(columns.core[Dim == 3 ? Core::motion : Core::place], 3, 1, 1);
    if (name == "ln_J") return lanes(columns.core[Dim == 3 ? Core::normal : Core::motion], Dim == 3 ? 3 : 2, 1, 1);
    if (name == "history_0") return lanes(columns.core[Dim == 3 ? Core::shear : Core::motion], 3, 1, 1);
    if (name == "history_1" && columns.second_history) return {{columns.second_history, size, 1, 0, 1, 1, 0}};
    if (name == "stress") return tensor(columns.core[Core::normal], columns.core[Core::shear]);
    if (name == "left_strain") return tensor(columns.stretch[0], columns.stretch[stretch_rows<Dim> - 1]);
    if (name == "log_stretch") return lanes(columns.log_stretch, 0, Dim, Dim);
    std::vector<RowPart> all;
    for (int k = 0; name == "affine" && columns.affine[0] && k < affine_rows<Dim>; ++k)
        all.push_back(lanes(columns.affine[k], 0, Dim == 3 ? 3 : 4, Dim * Dim, Dim * k).front());
    return all;
}

}  // namespace moraine::gpu
