#pragma once
// Which tiles, and which of their nodes, a rank exchanges with each other rank (see epoch.hpp for the rule).
//
// Only blocks with a foreign neighbour are looked at. What goes of a tile depends on the set of offsets at which the
// other side has blocks: a bit mask, tested against the offsets whose tiles cover a node.

#include "blocks/epoch.hpp"

namespace moraine {

/// By rank; from `ghost`, `ghost_owner`, `neighbour` and `boundary`. Not collective.
template <int Dim>
std::vector<PeerHalo> halo_lists(const EpochTables<Dim>& tables, int width);

}  // namespace moraine
