#pragma once
// A run begins on the device: a kernel writes the particles of a lattice (core/data/lattice.hpp) into the rows of the
// blocks that this rank owns, in list order. Nothing is computed but indices, so the bits are the host's.

#include <cuda_runtime.h>

#include "core/data/lattice.hpp"
#include "gpu/memory/array.hpp"
#include "gpu/memory/particle_rows.hpp"

namespace moraine::gpu {

/// Tables of a lattice on the device.
template <class Real, int Dim>
class DeviceLattice {
  public:
    /// Synchronous.
    explicit DeviceLattice(const LatticeTables<Real, Dim>& tables) {
        body_.assign(tables.body);
        bound_.assign(tables.bound);
        index_.assign(tables.index);
        u_.assign(tables.u);
        stress_.assign(tables.stress);
        flow_.assign(tables.flow);
    }
    LatticeView<Real, Dim> view() const {
        return {body_.data(), static_cast<int>(body_.size()), bound_.data(), index_.data(), u_.data(), stress_.data(),
                flow_.data()};
    }

  private:
    Array<LatticeBody<Real, Dim>> body_;
    Array<std::uint32_t> bound_, index_;
    Array<Coordinate<Real>> u_;
    Array<Vec<Real, 3>> stress_;
    Array<Vec<Real, Dim>> flow_;
};

/// Particles of block b, at position[b], go to slots first[b] to first[b + 1], by (cell, id). All rows besides the core
/// are zeros already. Asynchronous.
template <class Real, int Dim>
void seed_blocks(int own, const LatticeView<Real, Dim>& lattice, const Vec<std::int32_t, Dim>* position,
                 const std::uint32_t* first, const Columns<Real, Dim>& to, cudaStream_t stream);

}  // namespace moraine::gpu
