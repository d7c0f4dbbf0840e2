#pragma once
// What the kernels of nodes are told (gpu/kernels/nodes/nodes.hpp). Plain data, for kernels and their launches alike.

#include <cstdint>
#include <type_traits>

#include "core/fluid/particle_shifting.hpp"
#include "core/nodes/nodes.hpp"
#include "core/structures/contact_field.hpp"
#include "core/structures/gap_tiles.hpp"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

/// Distance of nodes of blocks that the ground is not near, and more than that of any other [m].
inline constexpr double far_from_ground = 1e300;

struct NearBlocks {
    const std::int32_t* list;    ///< node blocks
    const std::uint32_t* count;  ///< of them
    const std::uint8_t* mark;    ///< by node block: it is one of them; null: the scene has no structures
};

/// What nodes want of the structures of a step; all of it on the device.
template <int Dim>
struct NodeContact {
    ContactField<Dim> field;
    GapTiles gaps;
    NearBlocks near;
    bool acts = true;         ///< at nodes: not where surfaces act themselves (gpu/kernels/surfaces)
    SurfaceSpace surfaces{};  ///< those
};

/// Numbers of blocks that light nodes ask for: LimitedBlocks of two parts.
inline constexpr int light_counts = 4;

/// Which node blocks have light nodes (core/grid/light_stencil.hpp), for those who limit what they do.
template <class Real>
struct LightMarks {
    std::uint8_t* of;      ///< node block x light_marks: some of its nodes hold less than `mass`; null: nobody asks
    Real mass;             ///< [kg]
    std::uint32_t* count;  ///< light_counts numbers of blocks, which begin anew
};
/// Marks of a node block: one per warp, or half a warp in 2-D.
template <int Dim>
inline constexpr int light_marks = Block<Dim>::cells < 32 ? 1 : Block<Dim>::cells / 32;

/// What nodes leave in the last lane of their values for fluids that want it: P_i, the mean over mass of their
/// particles' mean stress, or in steps that shift e_i (core/fluid/particle_shifting.hpp).
template <class Real, int Dim>
struct NodeFluid {
    bool shifts;
    NodeCapacity<Real, Dim> capacity;
    Real inverse_volume;  ///< 1 / h^d [1/m3]
};

template <class Real, int Dim>
struct NodeWork {
    View<Real, Dim> view;
    NodeRound<Real, Dim> round;
    int origin;
    Quantum quantum;
    LightMarks<Real> marks;
    NodeContact<Dim> contact;
};

/// With what fluids want; nodes of other scenes do not get it.
template <class Real, int Dim>
struct FluidNodeWork : NodeWork<Real, Dim> {
    NodeFluid<Real, Dim> fluid;
};
template <class Real, int Dim, bool Fluid>
using NodeWorkOf = std::conditional_t<Fluid, FluidNodeWork<Real, Dim>, NodeWork<Real, Dim>>;

}  // namespace moraine::gpu
