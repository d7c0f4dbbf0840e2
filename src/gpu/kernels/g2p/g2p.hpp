#pragma once
// Grid to particles on the device: how it is launched. Plain C++; the kernels are compiled elsewhere, one file per
// precision, dimension and kind.
//
// Two ways to the stress. Fused: gather and law in one kernel, for what most runs are: hats or quadratic splines, with
// splines also an affine field, all of a step in one round (USL), one material. Split: a gather that leaves
// dL = dt grad v per list entry, and one stress launch per material. Which way a scene goes is decided once; the two
// differ in rounding. Fluids that take more from the grid have instances of both (fluid.cuh).
//
// A launch is any number of thread blocks >= 1: items are taken in turn up to a count that the device knows.
//
// Blocks in which light nodes limit an acceleration are few in most scenes: a kernel finds them, the gather passes them
// by, and an instance of it that asks every particle takes them.

#include <driver_types.h>

#include <memory>
#include <type_traits>

#include "comm/fused_gather.hpp"
#include "core/grid_pressure.hpp"
#include "core/light_nodes.hpp"
#include "core/particle_update.hpp"
#include "core/place_step.hpp"
#include "core/pressure_smoothing.hpp"
#include "core/scene_spec.hpp"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

/// Where and how wide a launch goes.
struct Launch {
    int blocks;  ///< about how many blocks of particles there are: makes the grid, any guess is right
    cudaStream_t stream;
};

/// For a method that limits accelerations at light nodes (core/light_nodes.hpp).
template <class Real>
struct LightArgs {
    const Stiffness<Real>* stiffness;  ///< by body, on the device; null: nothing is limited
    ReactionLimits<Real> limits;
    Real full_mass;             ///< the largest of the bodies' [kg]
    const std::uint8_t* marks;  ///< of node blocks (kernels/nodes/nodes.hpp)
    std::uint8_t* limited;      ///< own blocks: whether some particle's acceleration is limited
};

template <class Real, int Dim>
struct GatherArgs {
    DomainEnds<Real, Dim> ends;
    unsigned gather;               ///< bits of Gather (core/particle_update.hpp)
    bool tpic;                     ///< C_p is the velocity gradient
    Real flip;                     ///< share of FLIP [-]
    Real dt;                       ///< [s]
    double gravity_impulse[Dim];   ///< integral of gravity up to the end of this step [m/s]
    Quantum quantum;               ///< of the exact sums
    const std::uint8_t* averaged;  ///< by body, on the device: which take it from the cell; null: all
    bool averages;                 ///< some do
    LightArgs<Real> light;
    Real* gradient;                 ///< split: dL by component (row first) and list entry; fused: not used
    std::uint64_t gradient_stride;  ///< list entries between components
};

/// What fluids take from the grid besides their motion, as kernels are compiled for it: nothing; the means of nodes
/// (core/pressure_smoothing.hpp, core/particle_shifting.hpp); these, and the pressure of cells
/// (core/grid_pressure.hpp).
enum class FluidGrid { none, means, pressure };

template <class Real>
struct FluidArgs {
    const FluidTerms<Real>* by_body;  ///< on the device; null: of all particles the same
    FluidTerms<Real> all;
    bool shifts;  ///< in this step; nodes hold e_i then, else P_i (kernels/nodes/nodes.hpp)
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

/// One gather kernel with what is fixed in a run. Not collective.
template <class Real, int Dim>
class GatherKernel {
  public:
    virtual ~GatherKernel() = default;
    /// Of all chosen blocks that are not limited.
    virtual void run(const View<Real, Dim>& view, const Chosen& chosen, const FluidGatherArgs<Real, Dim>& args,
                     const Launch& launch) const = 0;
    /// Of limited blocks alone: the same, and what their light nodes cannot bear is taken from their gradients.
    virtual void run_limited(const View<Real, Dim>& view, const Chosen& limited, const FluidGatherArgs<Real, Dim>& args,
                             const Launch& launch) const = 0;
};

/// Where the limited ones of the chosen blocks are listed, and those that have to be asked. The order has no meaning.
struct LimitedBlocks {
    static constexpr int lists = 2;
    static constexpr int of_marked = 2;  ///< place of their number
    std::int32_t *limited, *marked;
    std::uint32_t* count;  ///< of limited blocks, and of_marked behind it; they begin at zero
};

/// Looks for the chosen blocks in which an acceleration is limited: sets LightArgs::limited of each, and lists them.
template <class Real, int Dim>
using FindLimited = void (*)(const View<Real, Dim>& view, const Chosen& chosen, const GatherArgs<Real, Dim>& args,
                             const LimitedBlocks& found, const Launch& launch);

template <class Real, int Dim>
FindLimited<Real, Dim> choose_find_limited(moraine::Shape shape);

/// One material's stress update. Not collective.
template <class Real, int Dim>
class StressKernel {
  public:
    virtual ~StressKernel() = default;
    virtual void run(const View<Real, Dim>& view, const Chosen& chosen, const StressArgs<Real, Dim>& args,
                     const Launch& launch) const = 0;
};

/// Gather without stress; averages: some bodies take their volumetric part from the cell (core/volumetric.hpp).
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_gather(moraine::Shape shape, bool affine, bool averages);

/// Gather with the material's stress; ignores GatherArgs::gather. For scenes that fuses() names
/// (comm/fused_gather.hpp). affine: of quadratic splines, whatever `shape` says; GatherArgs::flip is ignored then, for
/// APIC and TPIC have none.
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fused_gather(const MaterialSpec& material, moraine::Shape shape,
                                                           bool affine);

/// The same for a scene, or a material of quadratic splines, with fluid terms.
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fluid_gather(moraine::Shape shape, bool affine);
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fused_fluid_gather(const MaterialSpec& material, bool affine);

/// The same for scenes whose pressure is the grid's; quadratic splines alone.
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_pressure_gather(bool affine);
template <class Real, int Dim>
std::unique_ptr<GatherKernel<Real, Dim>> make_fused_pressure_gather(const MaterialSpec& material, bool affine);

template <class Real, int Dim>
std::unique_ptr<StressKernel<Real, Dim>> make_stress(const MaterialSpec& material);

}  // namespace moraine::gpu
