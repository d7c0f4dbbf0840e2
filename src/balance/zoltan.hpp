#pragma once
// Zoltan's geometric and hypergraph partitioners.
//
//   rcb    recursive coordinate bisection of the blocks' positions
//   hsfc   Zoltan's own Hilbert curve, cut by bisection
//   phg    multilevel hypergraph partitioning (Devine et al. 2006, doi 10.1109/IPDPS.2006.1639359). A net is a
//          tile with all blocks that need it, so what it counts is what the halo sends: a tile once to each rank.
//          Blocks that have owners are repartitioned: moving them counts against the halo of balance.interval steps
//
// Zoltan runs serially, on MPI_COMM_SELF, with NUM_GLOBAL_PARTS = P; ids are indices into the list of blocks. Its
// weights are single precision. The seed is set before each call, so a call does not depend on those before it.

#include <cstdint>
#include <span>
#include <vector>

#include "balance/load.hpp"

namespace moraine {

enum class ZoltanMethod { rcb, hsfc, phg };

/// Not collective.
bool zoltan_is_built();

/// See LibraryPartitioner::Find. `steps`: until the next partition, for phg. Not collective.
std::vector<std::int32_t> zoltan_parts(ZoltanMethod method, const Layout& layout, int steps,
                                       std::span<const BlockLoad> blocks, int parts);

}  // namespace moraine
