#pragma once
// Gaps on the device: minima and sums of whole numbers in shared memory, by the formulas of
// core/structures/particle_gaps.hpp.
//
// A thread block per pair of a block and a structure. Integer atomics are exact in any order, so the tiles are the same
// in every run. Which pairs there are follows from the epoch and from where structures stand, and is made by the host
// (blocks/contact_pairs.hpp): once per epoch, or in each step where one moves. With them go the planes over the ground
// (core/structures/ground_bound.hpp), so that most particles of a thick flow ask for no distance.
//
// The ground does not move: what the nodes want of it (GroundNode) is found once per epoch, for all nodes of the blocks
// that it is near, and read in each step.

#include <cuda_runtime.h>

#include "blocks/contact_pairs.hpp"
#include "core/grid/shape.hpp"
#include "core/particles/place_step.hpp"
#include "core/structures/contact.hpp"
#include "gpu/kernels/view.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

/// The pairs on the device, and the tiles.
template <int Dim>
class DeviceGaps {
  public:
    void forget() {
        pairs_.forget();
        knows_ground_ = false;
    }
    /// Asynchronous.
    void make(const EpochTables<Dim>& tables, const ContactField<Dim>& on_host, bool moved, int width,
              cudaStream_t stream) {
        if (!pairs_.make(tables, on_host, moved)) return;
        tile_of_.assign(pairs_.tile_of(), stream);
        boundary_.assign(pairs_.boundary(), stream);
        interior_.assign(pairs_.interior(), stream);
        if (pairs_.bounds()) bounds_.assign(std::vector(pairs_.bounds(), pairs_.bounds() + tables.own.size()), stream);
        tiles_.resize(pairs_.tiles() * static_cast<std::size_t>(power<Dim>(tile_side(width))));
    }

    /// The ground at the nodes of an epoch's node blocks; null where the scene has none. contact: on the device.
    /// Asynchronous.
    GroundNode<Dim>* ground(const BlockTable<Dim>& table, const ContactField<Dim>& contact, int origin,
                            cudaStream_t stream);

    GapTiles view() const { return {pairs_.structures(), tile_of_.data(), tiles_.data()}; }
    NodeGap* tiles() const { return tiles_.data(); }
    const Array<ContactPair>& boundary() const { return boundary_; }
    const Array<ContactPair>& interior() const { return interior_; }
    /// By own block; null: there is no ground.
    const GroundBound<Dim>* bounds() const { return pairs_.bounds() ? bounds_.data() : nullptr; }

  private:
    ContactPairs<Dim> pairs_;
    Array<std::int32_t> tile_of_;
    Array<ContactPair> boundary_, interior_;
    Array<NodeGap> tiles_;
    Array<GroundBound<Dim>> bounds_;
    Array<GroundNode<Dim>> ground_;
    bool knows_ground_ = false;  ///< in this epoch
};

/// Brings particles of these pairs that are too deep in their structure back (core/structures/particle_depth.hpp), and
/// notes those that are buried. contact: on the device; pairs: of `gaps`. Asynchronous.
template <class Real, int Dim>
void limit_depths(const View<Real, Dim>& view, const DomainEnds<Real, Dim>& ends, const ContactField<Dim>& contact,
                  const DeviceGaps<Dim>& gaps, const Array<ContactPair>& pairs, cudaStream_t stream);

/// Fills the tiles of these pairs. contact: on the device; pairs: of `gaps`. Asynchronous.
template <class Real, int Dim>
void find_gaps(const View<Real, Dim>& view, Shape shape, const ContactField<Dim>& contact, const DeviceGaps<Dim>& gaps,
               const Array<ContactPair>& pairs, cudaStream_t stream);

}  // namespace moraine::gpu
