#pragma once
// METIS: the graph of blocks cut into parts of equal load with few shared nodes between them, by multilevel
// k-way partitioning (Karypis and Kumar 1998, doi 10.1006/jpdc.1997.1404).
//
// METIS counts in 32 bits: loads are scaled so that their sum is at most 2^30, and a graph that does not fit is
// refused. It balances to 1 %, or as well as the heaviest block lets it. The seed is fixed. While it runs it
// takes SIGTERM for an error of its own: the calling thread holds the signal back until it is done.

#include <cstdint>
#include <span>
#include <vector>

#include "balance/load.hpp"

namespace moraine {

/// Not collective.
bool metis_is_built();

/// See LibraryPartitioner::Find. Not collective.
std::vector<std::int32_t> metis_parts(const Layout& layout, std::span<const BlockLoad> blocks, int parts);

/// Loads whose sum is at most 2^30, in proportion; what weighs something still does. Not collective.
std::vector<std::int32_t> metis_loads(std::span<const BlockLoad> blocks);

/// Throws InputError if METIS cannot count so many entries of the graph, or so many shared nodes in all.
/// Not collective.
void refuse_metis_graph(std::int64_t entries, std::int64_t shared);

}  // namespace moraine
