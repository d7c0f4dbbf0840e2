#pragma once
// What tractions know of a particle on the device, in its rows (core/particles/particle_state.hpp).

#include "core/particles/particle_load.hpp"
#include "gpu/kernels/copy_async.cuh"
#include "gpu/memory/particle_rows.hpp"

namespace moraine::gpu {

/// Its load_place under traction k.
template <class Real, int Dim>
__device__ __forceinline__ Real load_place(const Columns<Real, Dim>& p, std::uint32_t slot, int k) {
    constexpr int first = moraine::place_of<Dim>("load_place").row;
    return p.load[first + k / 4][slot].e[k % 4];
}

/// The rows of its F - I.
template <class Real, int Dim>
struct DeformationRows {
    static constexpr int first = moraine::place_of<Dim>("deformation").row;
    static constexpr int lanes = moraine::place_of<Dim>("deformation").lanes, rows = Dim * Dim / lanes;
    Row<Real> row[rows];

    __device__ __forceinline__ DeformationRows(const Columns<Real, Dim>& p, std::uint32_t slot) {
#pragma unroll
        for (int r = 0; r < rows; ++r) row[r] = load_row(p.load[first + r] + slot);
    }
    __device__ __forceinline__ Mat<Real, Dim> get() const {
        Mat<Real, Dim> m;
#pragma unroll
        for (int i = 0; i < Dim * Dim; ++i) m(i / Dim, i % Dim) = row[i / lanes].e[i % lanes];
        return m;
    }
    __device__ __forceinline__ void set(const Mat<Real, Dim>& m) {
#pragma unroll
        for (int i = 0; i < Dim * Dim; ++i) row[i / lanes].e[i % lanes] = m(i / Dim, i % Dim);
    }
    __device__ __forceinline__ void store(const Columns<Real, Dim>& p, std::uint32_t slot) const {
#pragma unroll
        for (int r = 0; r < rows; ++r) store_row(p.load[first + r] + slot, row[r]);
    }
};

}  // namespace moraine::gpu
