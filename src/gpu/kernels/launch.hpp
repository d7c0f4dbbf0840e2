#pragma once
// Where a launch goes. A launch is any number of thread blocks >= 1: items are taken in turn up to a count that the
// device knows.

#include <driver_types.h>

namespace moraine::gpu {

/// Where and how wide a launch goes.
struct Launch {
    int blocks;  ///< about how many blocks of particles there are: makes the grid, any guess is right
    cudaStream_t stream;
};

/// Thread blocks of a launch over lists that are mostly short: at most 8 on each of an H200's 132 multiprocessors, and
/// each goes on to its next items.
inline int few_blocks(int blocks) {
    return blocks < 1056 ? blocks : 1056;
}

/// Thread blocks for about so many blocks of particles, by the teams of gpu/kernels/team.cuh.
template <int Dim>
unsigned team_grid(int blocks) {
    constexpr int teams = Dim == 3 ? 1 : 4;
    return blocks > teams ? static_cast<unsigned>((blocks + teams - 1) / teams) : 1;
}

}  // namespace moraine::gpu
