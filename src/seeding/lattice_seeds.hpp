#pragma once
// Scenes of boxes that a lattice fills, without going through their particles: the tables of core/data/lattice.hpp, and
// the blocks that are occupied. All in closed form, in a time that grows with blocks alone; seeding/seed.hpp is the
// reference, and has all other bodies.

#include "blocks/topology.hpp"
#include "core/data/lattice.hpp"
#include "core/transfer/method.hpp"

namespace moraine {

/// Whether all bodies are boxes on a lattice, without jitter, that no structure takes particles from, of laws whose
/// scalars begin as zeros.
bool is_lattice(const Scene& scene);

/// For a scene that is_lattice(). Not collective.
template <class Real, int Dim>
LatticeTables<Real, Dim> lattice_tables(const Scene& scene, const Method<Host, Real, Dim>& method,
                                        const DomainBlocks<Dim>& domain);

struct LatticeBlock {
    Key key;
    std::uint32_t particles;
    std::uint32_t cells;  ///< that hold particles; 0 unless asked for
};

/// The occupied blocks of all ranks, in key order. Not collective.
template <class Real, int Dim>
std::vector<LatticeBlock> lattice_blocks(const LatticeTables<Real, Dim>& tables, bool with_cells);

}  // namespace moraine
