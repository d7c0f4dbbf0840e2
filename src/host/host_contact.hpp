#pragma once
// The structures of a scene as the host's blocks see them: who is near whom, the gaps between particles and
// structures, and the ground at the nodes. The mirror of gpu/contact_state.hpp.
//
// Gaps are found once a step, with the sums of its first round, and kept for all its rounds.

#include <limits>
#include <vector>

#include "blocks/contact_pairs.hpp"
#include "comm/halo.hpp"
#include "core/data/host.hpp"
#include "core/structures/particle_depth.hpp"
#include "core/structures/structure_set.hpp"

namespace moraine {

template <int Dim>
struct HostContact {
    const bool at_nodes;  ///< structures act there, and not at their surfaces (Bed)
    ContactPairs<Dim> pairs{};
    std::vector<GroundNode<Dim>> ground{};  ///< in this epoch; empty: there is none, or nothing is known
    Host::Array<NodeGap> gaps{};
    ContactField<Dim> field{};  ///< of this step's gaps
    bool finding = false;       ///< gaps, in this round
    Buried<Dim> buried{};       ///< of this step
    GapShare<Dim> share{};

    /// Gaps are found in the next sums, at tiles of `side` nodes. Returns whether the pairs are new. Not collective.
    bool begin(const StructureSet<Dim>& structures, const EpochTables<Dim>& tables, int side) {
        field = structures.field();
        finding = true;
        if (ground.empty() && field.structure[0].shape == StructureShape::ground)
            ground.assign(tables.node_position.size() * Block<Dim>::cells,
                          {{std::numeric_limits<double>::quiet_NaN(), {}}, 0, 0});
        if (!pairs.make(tables, field, structures.any_moves())) return false;
        if (!at_nodes) return true;
        gaps.resize(pairs.tiles() * static_cast<std::size_t>(power<Dim>(side)));
        share = {&pairs, gaps.data()};
        return true;
    }
    /// What travels with the sums of this round; null: nothing.
    const GapShare<Dim>* to_share() const { return finding && at_nodes ? &share : nullptr; }
    /// Structures as nodes meet them, with what they feel in `sums`.
    ContactField<Dim> field_with(const StructureSet<Dim>& structures, StructureSums<Dim>* sums,
                                 TurningSums<Dim>* turning) {
        ContactField<Dim> now = structures.field();
        now.sums = sums;
        now.turning = turning;
        now.ground = ground.empty() ? nullptr : ground.data();
        return now;
    }
    /// An epoch has begun.
    void forget() {
        pairs.forget();
        ground.clear();
    }
};

}  // namespace moraine
