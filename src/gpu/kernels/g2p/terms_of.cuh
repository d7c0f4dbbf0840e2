#pragma once
// The terms of the gathers on devices, in their order; a case has those that it is compiled with.

#include "gpu/kernels/g2p/box.cuh"
#include "gpu/kernels/g2p/cell_step.cuh"
#include "gpu/kernels/g2p/deformation.cuh"
#include "gpu/kernels/g2p/fluid.cuh"
#include "gpu/kernels/g2p/light.cuh"
#include "gpu/kernels/g2p/volumetric.cuh"

namespace moraine::gpu {

template <class Case>
using TermsOf =
    TeamTerms<LightTerm<Case>, FluidTerm<Case>, PressureTerm<Case>, BoxTerm<Case>, LoadTerm<Case>, MeansTerm<Case>>;

/// What a gather sums for the particle in slot s, less what its light nodes cannot bear. gathered(): the sums.
template <class Case, bool Affine>
__device__ __forceinline__ auto gather_limited(const BlockInWork<Case>& in, auto& shared, std::uint32_t s,
                                               const auto& gathered) {
    if constexpr (Case::light)
        return LightTerm<Case>::template around<Affine>(in, shared, s, gathered);
    else
        return gathered();
}

}  // namespace moraine::gpu
