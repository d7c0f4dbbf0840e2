#pragma once
// A set of blocks grown by neighbours: the topology from the occupied blocks, node blocks from a rank's own.
//
// Each family adds its reach to the families around it: bits to those in the set, and a list of the others, which are
// few (the surface), made unique by a hash table and sorted only then. Asking the neighbours of each possible block
// instead would need that list first.

#include "blocks/surroundings.hpp"

namespace moraine {

enum class Reach {
    around,  ///< all neighbours that lie in the domain
    upwards  ///< upper corners, also beyond the domain: tiles reach over it
};

/// The blocks of `index` and all that they reach. Not collective.
template <int Dim>
BlockIndex<Dim> grown(const BlockIndex<Dim>& index, const DomainBlocks<Dim>& domain, Reach reach);

}  // namespace moraine
