#pragma once
// Which rank gets which part of a new partition, so that few particles move.
//
// Greedy: of all pairs (part, rank) the one with most particles that stay is joined first; ties go to
// the lower part, then to the lower rank; parts that are left over keep their number if that rank is
// free. The result never keeps fewer particles than natural order (part p to rank p), and reproduces
// the present owners if the parts are those of now. Not the exact assignment: it costs O(P^3) and greedy
// keeps at least half of what it keeps.

#include <cstdint>
#include <span>
#include <vector>

#include "balance/load.hpp"

namespace moraine {

/// The rank of each part, every rank once. part_of[b] is the part of block b, in [0, ranks). A block
/// whose owner is not in [0, ranks) stays nowhere. `wanted`: the rank that somebody found for each part, no
/// rank twice, -1 for none; it is filled up by greed and taken if nothing else keeps as much.
/// Not collective.
std::vector<std::int32_t> relabel(std::span<const BlockLoad> blocks, std::span<const std::int32_t> part_of, int ranks,
                                  std::span<const std::int32_t> wanted = {});

/// Particles of a part that a rank holds.
struct Overlap {
    std::int32_t part;
    std::int32_t rank;
    std::int64_t particles;
};

/// Of each part and present owner in [0, ranks), at most one; by part, then rank. Not collective.
std::vector<Overlap> overlaps(std::span<const BlockLoad> blocks, std::span<const std::int32_t> part_of, int ranks);

/// relabel() of overlaps in that order. Not collective.
std::vector<std::int32_t> relabel_pairs(std::vector<Overlap> pairs, int ranks,
                                        std::span<const std::int32_t> wanted = {});

struct Moved {
    std::int64_t particles = 0;
    std::int64_t blocks = 0;
};

/// What travels if block b goes to owners[b]. A block that nobody holds yet does not travel. Not collective.
Moved moved(std::span<const BlockLoad> blocks, std::span<const std::int32_t> owners);

}  // namespace moraine
