#pragma once
// What the compiler knows of a gather on a device, and how it composes the terms of a scene (core/terms/terms.hpp).
//
// Here a term is a struct of static functions: its data are arguments of the kernel (gather_args.hpp) and its part of
// the team's shared memory. Without its physics an instance has none of its hooks, and no memory for it. at_block and
// at_cell are called by whole teams, before and behind the block's tile; before_gather puts into shared memory what in
// registers would be too much.
// The stress is the last term of the fused gather, "store dL" that of the split one. Both show a particle by the same
// names (g2p_fused.cuh, g2p_split.cuh), so that a term is written once. The list is in terms_of.cuh.

#include "core/terms/terms.hpp"
#include "gpu/kernels/g2p/g2p_particle.cuh"

#define MORAINE_TEAM static __device__ __forceinline__

namespace moraine::gpu {

/// Physics that an instance is compiled with, as bits.
enum GatherTerms : unsigned {
    no_terms = 0,
    light_term = 1,         ///< of blocks that find_limited.cuh has listed
    means_term = 2,         ///< means of cells
    fluid_term = 4,         ///< pressures are smoothed, particles shifted, by a number per node
    pressure_term = 4 | 8,  ///< particles are shifted, and the pressure is the grid's
    surface_term = 16,      ///< with those: surfaces act where they are
    load_term = 32          ///< tractions
};

template <class R, int D, class S, bool A, unsigned Terms>
struct GatherCase {
    using Real = R;
    using Shape = S;
    static constexpr int dim = D, side = tile_side(S::width);
    static constexpr bool affine = A;
    static constexpr bool light = (Terms & light_term) != 0, means = (Terms & means_term) != 0;
    static constexpr bool fluid = (Terms & fluid_term) != 0, pressure = (Terms & pressure_term) == pressure_term;
    static constexpr bool surfaces = fluid && (Terms & surface_term) != 0;
    static constexpr bool loads = (Terms & load_term) != 0;
    using Args = GatherArgsOf<R, D, pressure ? FluidGrid::pressure : fluid ? FluidGrid::means : FluidGrid::none>;
    using T = Team<D>;
    using U = Vec<Coordinate<R>, D>;
    using Seen = SeenOf<R, pressure>;
};

/// A block in work, and all that the kernel is told.
template <class Case>
struct BlockInWork {
    const View<typename Case::Real, Case::dim>& v;
    const typename Case::Args& g;
    const Work& work;
};

template <class... T>
struct TeamTerms {
    struct Shared : T::Shared... {};

    /// Calls f(term, its shared memory) for each that has the hook, in order.
    template <unsigned Hook>
    MORAINE_TEAM void each(Shared& shared, const auto& f) {
        (call<Hook, T>(shared, f), ...);
    }

  private:
    template <unsigned Hook, class One>
    MORAINE_TEAM void call(Shared& shared, const auto& f) {
        if constexpr ((One::hooks & Hook) != 0) f(One{}, static_cast<typename One::Shared&>(shared));
    }
};

/// The shared memory of a term, if an instance has it.
template <class Term>
struct NoShared {};
template <class Term, bool Present, class Memory>
using SharedIf = std::conditional_t<Present, Memory, NoShared<Term>>;

}  // namespace moraine::gpu
