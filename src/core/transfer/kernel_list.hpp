#pragma once
// The list of compiled kernels: dimension x precision x shape, each with and without an affine field.
//
// A scene chooses one row by name at its start. Each (dimension, precision, shape) is one source file
// (kernel_list.cpp.in), so the list is compiled in parallel and its cost is visible.

#include "core/data/processor.hpp"
#include "core/grid/stencil.hpp"
#include "core/particles/law_batch.hpp"
#include "core/structures/particle_gaps.hpp"

namespace moraine {

/// What both transfers need to know, apart from their own parameters.
template <class Real, int Dim>
struct TransferCall {
    StencilContext<Real, Dim> context;
    ParticleView<Real, Dim> particles;
    BlockTable<Dim> table;
    ListView<Dim> list;
    TileView<Real> grid;
    const std::int32_t* chosen;       ///< own blocks
    std::int64_t count;               ///< of them
    NodeMean mean = NodeMean::none;   ///< what nodes sum besides
    const Real* grid_bulk = nullptr;  ///< by body: K where the pressure is the grid's, else 0; null: nowhere [Pa]
};

/// What the gather needs besides (gather_call.hpp).
template <class Real, int Dim>
struct GatherCall;

/// What the gaps to structures need besides: they are found by pairs of a block and a structure.
template <int Dim>
struct GapCall {
    ContactField<Dim> field;
    NodeGap* tiles;
    const ContactPair* pairs;
    std::int64_t count;
    const GroundBound<Dim>* bounds = nullptr;  ///< by block; null: there is no ground
};

template <class Real, int Dim>
struct TransferKernels {
    void (*p2g)(const TransferCall<Real, Dim>&, Real cell);
    void (*g2p)(const TransferCall<Real, Dim>&, const GatherCall<Real, Dim>&);
    void (*gaps)(const TransferCall<Real, Dim>&, const GapCall<Dim>&);
};

/// One row of the list; defined once per compiled combination, and again for AVX-512 where that pays (processor.hpp).
template <class Real, int Dim, class Shape>
TransferKernels<Real, Dim> transfer_kernels_any(bool affine);
template <class Real, int Dim, class Shape>
TransferKernels<Real, Dim> transfer_kernels_avx512(bool affine);

/// The row of a scene, for this processor.
template <class Real, int Dim>
TransferKernels<Real, Dim> choose_kernels(Shape shape, bool affine);

}  // namespace moraine
