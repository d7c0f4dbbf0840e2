#pragma once
// What the gathers and stress updates of a step are told (gpu/kernels/g2p/g2p.hpp). Plain data, for kernels and their
// launches alike.

#include <cstdint>
#include <type_traits>

#include "core/data/scene_choices.hpp"
#include "core/fluid/grid_pressure.hpp"
#include "core/fluid/pressure_smoothing.hpp"
#include "core/grid/light_nodes.hpp"
#include "core/grid/particle_update.hpp"
#include "core/particles/particle_load.hpp"
#include "core/particles/place_step.hpp"
#include "core/structures/surface_space.hpp"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

/// For a method that limits accelerations at light nodes (core/grid/light_nodes.hpp).
template <class Real>
struct LightArgs {
    const Stiffness<Real>* stiffness;  ///< by body, on the device; null: nothing is limited
    ReactionLimits<Real> limits;
    Real full_mass;             ///< the largest of the bodies' [kg]
    const std::uint8_t* marks;  ///< of node blocks (kernels/nodes/nodes.hpp)
    std::uint8_t* limited;      ///< own blocks: whether some particle's acceleration is limited
};

/// What tractions did in a step: work [J], then impulse by axis [kg m/s].
template <int Dim>
struct LoadSums {
    ExactSum of[Dim + 1];
};

template <class Real, int Dim>
struct LoadArgs {
    const ParticleLoad<Real, Dim>* of;  ///< by list entry; null: the scene has no tractions
    const std::uint8_t* loaded;         ///< own blocks: whether some particle is given any; if not, `of` is not set
    LoadSums<Dim>* sums;
};

template <class Real, int Dim>
struct GatherArgs {
    DomainEnds<Real, Dim> ends;
    unsigned gather;               ///< bits of Gather (core/grid/particle_update.hpp)
    bool tpic;                     ///< C_p is the velocity gradient
    Real flip;                     ///< share of FLIP [-]
    Real dt;                       ///< [s]
    double gravity_impulse[Dim];   ///< integral of gravity up to the end of this step [m/s]
    Quantum quantum;               ///< of the exact sums
    const std::uint8_t* averaged;  ///< by body, on the device: which take it from the cell; null: all
    bool averages;                 ///< some do
    LightArgs<Real> light;
    LoadArgs<Real, Dim> loads;
    Real* gradient;                 ///< split: dL by component (row first) and list entry; fused: not used
    std::uint64_t gradient_stride;  ///< list entries between components
};

template <class Real>
struct FluidArgs {
    const FluidTerms<Real>* by_body;  ///< on the device; null: of all particles the same
    FluidTerms<Real> all;
    bool shifts;            ///< in this step; nodes hold e_i then, else P_i (kernels/nodes/nodes.hpp)
    SurfaceSpace surfaces;  ///< that act where they are
};

/// With them; kernels of other scenes do not get them.
template <class Real, int Dim>
struct MeansGatherArgs : GatherArgs<Real, Dim> {
    FluidArgs<Real> fluid;
};
/// With the pressure of cells; nodes hold e_i.
template <class Real, int Dim>
struct FluidGatherArgs : MeansGatherArgs<Real, Dim> {
    const CellPressure<Real>* cell;  ///< [tile][cell]
    const Real* bulk;                ///< by body: K [Pa]
};
template <class Real, int Dim, FluidGrid Fluid>
using GatherArgsOf = std::conditional_t<
    Fluid == FluidGrid::pressure, FluidGatherArgs<Real, Dim>,
    std::conditional_t<Fluid == FluidGrid::means, MeansGatherArgs<Real, Dim>, GatherArgs<Real, Dim>>>;

template <class Real, int Dim>
struct StressArgs {
    Real dt;  ///< [s]
    Quantum quantum;
    const Real* gradient;  ///< as in GatherArgs
    std::uint64_t gradient_stride;
    const std::uint16_t* material_of;  ///< by body, on the device; null: all particles are of this material
    int mine;                          ///< the material whose particles are updated
};

/// Where the limited ones of the chosen blocks are listed, and those that have to be asked. The order has no meaning.
struct LimitedBlocks {
    static constexpr int lists = 2;
    static constexpr int of_marked = 2;  ///< place of their number
    std::int32_t *limited, *marked;
    std::uint32_t* count;  ///< of limited blocks, and of_marked behind it; they begin at zero
};

}  // namespace moraine::gpu
