#pragma once
// What the kernels of surfaces are told (gpu/kernels/surfaces/surfaces.hpp). Plain data, for kernels and their launches
// alike.

#include "core/structures/contact.hpp"
#include "core/structures/particle_gaps.hpp"
#include "core/surfaces/open_rule.hpp"
#include "core/surfaces/surface_elements.hpp"
#include "gpu/kernels/pressure/pressure_work.hpp"

namespace moraine::gpu {

/// An own block near a surface (blocks/surface_block.hpp); what its pointers lead to stays over epochs.
template <int Dim>
struct SurfaceBed {
    std::int32_t block;  ///< own
    std::int32_t element_count, slave_count;
    SurfaceElement<Dim>* elements;  ///< gap, covered, touches, and the place on what turns, are of the step
    const SlaveNode<Dim>* slaves;
    const RingElement<Dim>* ring;
    const std::uint16_t *around, *first_around;  ///< by cell: of the ring
    const SurfaceCell<Dim>* cells;               ///< null: no cell is near, or pressures are the particles'
};

/// Of an epoch. A giver is a bed that has elements, slaves or cells.
template <int Dim>
struct SurfaceTables {
    const SurfaceBed<Dim>* bed;
    const std::int32_t* bed_of;      ///< by own block, or -1
    const std::int32_t* giver;       ///< beds
    const std::int32_t* near_nodes;  ///< node blocks
    const std::int32_t* near_of;     ///< by node block, or -1
    int near;                        ///< node blocks
    int ghosts;                      ///< blocks
};

/// Sums of a pass: tiles of ghosts, then of givers, and which of them gave.
template <class Real>
struct SurfaceTiles {
    Real* tile;             ///< [tile][node of tile][node_reals]
    std::int32_t* tile_of;  ///< by own block, then by ghost: its tile, or -1: it gives nothing
};

template <class Real, int Dim>
struct SurfaceWork {
    View<Real, Dim> view;
    ContactField<Dim> field;
    GapTiles gaps;
    SurfaceTables<Dim> tables;
    SurfaceTiles<Real> tiles;
    Real* shares;  ///< W_i [near node block][node][node_reals]
    int origin;    ///< of the stencil
    Real mass_cutoff;
    Quantum quantum;
    ContactTime time;
    const OpenCell<Real, Dim>* cells;  ///< [giver][cell]; null: pressures are the particles'
    double damping;                    ///< d of the grid's pressure [-]
};

/// Cells beside surfaces.
template <class Real, int Dim>
struct OpenTables {
    OpenGrid<Real, Dim> grid;
    const SpaceNode* const* node;            ///< [near node block]: of its nodes; stays over epochs
    OpenCell<Real, Dim>* cell;               ///< [giver][cell]
    Real* sums;                              ///< of a pass [near node block][node][node_reals]
    Vec<Real, Dim>* acceleration;            ///< HeldNode's, without cells [near node block][node]
    std::uint8_t *has_children, *has_roots;  ///< by giver
};

template <class Real, int Dim>
struct OpenWork : SurfaceWork<Real, Dim> {
    PressureView<Real, Dim> pressure;
    OpenTables<Real, Dim> open;
    double dt;         ///< dts [s]
    double half_time;  ///< half of that from the start of the step to the middle of the substep that updates [s]
    bool takes_roots;  ///< children have not been told yet
    bool updates;      ///< cells take the flux of the substep before
    bool presses;      ///< and push; else they are done and go to the gather
};

/// Of the kernel that finds gaps.
template <class Real, int Dim>
struct SurfaceGapWork {
    View<Real, Dim> view;
    ContactField<Dim> field;
    SurfaceTables<Dim> tables;
    const ContactPair* pairs;
    NodeGap* tiles;
    const GroundBound<Dim>* bounds;  ///< by own block; null: there is no ground
};

}  // namespace moraine::gpu
