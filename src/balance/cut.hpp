#pragma once
// The exact cut of a chain of blocks into contiguous parts: the heaviest part is as light as it can be.
//
// The smallest feasible bottleneck B is found by bisection over integers; a probe fills parts from the
// left and costs O(P log N) on prefix sums (Pinar and Aykanat 2004, doi 10.1016/j.jpdc.2004.05.003).
// Among the cuts whose parts are all <= B, each cut point in turn, from the left, is the one nearest to
// the mean of what remains (rounded down; the later one on a tie) that still lets the rest fit into B. With
// at least as many blocks as parts no part is empty; with fewer, the first parts get one block each.
//
// Not the prefix cut (a block goes where p * total / P falls): it can exceed the optimum by a block.

#include <cstdint>
#include <span>
#include <vector>

namespace moraine {

/// parts + 1 first positions: part p is [cuts[p], cuts[p + 1]). Weights not negative, their total below
/// 2^63, parts >= 1. If all weights are zero the blocks are counted instead. Not collective.
std::vector<std::int64_t> exact_cut(std::span<const std::int64_t> weights, int parts);

/// The number of parts, of 1 to `at_most`, whose heaviest weighs at most `limit` times their mean while one more part
/// would be too many; of several such numbers bisection takes one. Weights as above, at_most >= 1, limit >= 1. Not
/// collective.
std::int64_t even_parts(std::span<const std::int64_t> weights, std::int64_t at_most, double limit);

/// The weight of the heaviest part. Not collective.
std::int64_t heaviest_part(std::span<const std::int64_t> weights, std::span<const std::int64_t> cuts);

}  // namespace moraine
