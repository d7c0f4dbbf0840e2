#pragma once
// Memory refresh on the device: columns into list order, after which the lists are 0, 1, 2, ...
//
// One column at a time, through a spare one that the caller then swaps in or copies back: the price is one column of
// memory.

#include <cuda_runtime.h>

#include <cstdint>

namespace moraine::gpu {

/// Row k of `to` becomes row slot[k] of `from`. Rows of 2, 4, 8, 16 or 32 bytes, aligned to their size; n < 2^31.
void permute(std::uint32_t n, const std::uint32_t* slot, const void* from, void* to, int bytes_per_row,
             cudaStream_t stream);

/// Block b's row of `words` words becomes that of the block which was old[b]; rows of blocks that were not (-1) are
/// left.
void renumber(std::uint32_t blocks, std::uint32_t words, const std::int32_t* old, const std::uint32_t* from,
              std::uint32_t* to, cudaStream_t stream);

/// slot[k] = start + k
void count_up(std::uint32_t n, std::uint32_t* slot, cudaStream_t stream, std::uint32_t start = 0);

}  // namespace moraine::gpu
