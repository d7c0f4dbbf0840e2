#pragma once
// The structures of a scene on the device, the gaps between them and the particles, and the node blocks near them.
//
// Gaps are found once a step, with the sums of its first round, and kept for all its rounds. The depth of particles in
// the ground is limited once a step, too, though sums may be made twice (engine_epoch.cpp, grow_tiles()).

#include "blocks/epoch.hpp"
#include "gpu/kernels/gaps/gaps.hpp"
#include "gpu/kernels/nodes/device_structures.hpp"
#include "gpu/kernels/nodes/near_blocks.hpp"
#include "gpu/kernels/nodes/nodes.hpp"

namespace moraine::gpu {

template <int Dim>
struct ContactState {
    DeviceStructures<Dim> structures;
    DeviceGaps<Dim> gaps;
    DeviceNearBlocks<Dim> near_blocks;
    ContactField<Dim> field{};    ///< of this step's gaps
    NodeContact<Dim> at_nodes{};  ///< of this step's nodes
    bool finds_gaps = false;      ///< in this round
    bool limits_depths = false;   ///< in the next sums
    bool at_surfaces = false;     ///< they act there, and nodes only know where they are
    SurfaceSpace surfaces{};      ///< what nodes find of those
    bool rests = false;           ///< all that is here holds for the rest of the epoch: no structure moves

    /// Gaps are found in the next sums. Asynchronous.
    void begin(const StructureSet<Dim>& set, const EpochTables<Dim>& tables, const BlockTable<Dim>& table,
               const Stencil& stencil, cudaStream_t stream) {
        field = structures.place(set, stream);
        gaps.make(tables, set.field(), set.any_moves(), stencil.width, stream);
        field.ground = gaps.ground(table, field, stencil.origin, stream);
        finds_gaps = limits_depths = true;
    }
    /// The structures as nodes see them, with the ground of this epoch. Asynchronous.
    const NodeContact<Dim>& find_at_nodes(const StructureSet<Dim>& set, const BlockTable<Dim>& table,
                                          const Stencil& stencil, cudaStream_t stream) {
        ContactField<Dim> now = structures.place(set, stream);
        now.ground = field.ground;
        at_nodes = {now, gaps.view(), near_blocks.find(table, now, stencil.origin, set.any_moves(), stream),
                    !at_surfaces, surfaces};
        rests = !set.any_moves();
        return at_nodes;
    }
    /// An epoch has begun.
    void forget() {
        gaps.forget();
        near_blocks.forget();
        rests = false;
    }
};

}  // namespace moraine::gpu
