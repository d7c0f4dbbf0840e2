#pragma once
// What the terms of a gather see on the host: the compiled case, a cell in work, and one of its particles.

#include "core/data/grid_views.hpp"
#include "core/data/quad.hpp"
#include "core/grid/gather_sums.hpp"
#include "core/particles/particle_state.hpp"

namespace moraine {

template <class R, int D, class S, bool A>
struct GatherCase {
    using Real = R;
    using Shape = S;
    using T = Together<R, particles_together<R>>;  ///< particles of a cell that are gathered together
    static constexpr int dim = D;
    static constexpr bool affine = A;
    static constexpr int width = S::width, side = tile_side(width), tile_nodes = power<D>(side);
    static constexpr int batch = 64;  ///< particles whose stresses are updated at once
};

/// A cell in work.
template <class Case>
struct CellInWork {
    int block, number;
    std::uint32_t begin, end;                ///< list entries
    const Quad<typename Case::Real>* nodes;  ///< of the tile, from the first of the stencil on
    int base[Case::dim];                     ///< first node of the stencil
    unsigned ghosts[Case::dim];              ///< of the stencil (Walls::ghosts)
    bool at_wall;                            ///< some ghost is folded
    bool plain[Case::dim];                   ///< C is the velocity gradient

    /// More particles than a batch holds.
    MORAINE_HD bool crowded() const { return end - begin > unsigned(Case::batch); }
};

/// A particle in work: what it gathered, who makes its weights, and its state by the names that devices give it too
/// (CoreRows).
template <class Case, class StencilOf>
struct PointInWork {
    using Real = typename Case::Real;
    const ParticleView<Real, Case::dim>& all;
    std::uint32_t slot;
    const StencilOf& stencil_of;
    GatheredPart<typename Case::T, Case::dim> sums;

    MORAINE_HD Real& stress(int k) const { return all.stress[slot][k]; }
    MORAINE_HD Real& ln_J() const { return all.ln_J[slot]; }
    MORAINE_HD Real volume() const { return all.volume[slot]; }
    MORAINE_HD Real velocity(int a) const { return all.velocity[slot][a]; }
};

}  // namespace moraine
