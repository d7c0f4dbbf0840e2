#include <stdexcept>
#include <string>

#include "gpu/memory/array.hpp"
#include "gpu/memory/refresh.cuh"
#include "gpu/memory/refresh.hpp"

namespace moraine::gpu {

namespace {

template <class Unit, unsigned Units>
void launch(std::uint32_t n, const std::uint32_t* slot, const void* from, void* to, cudaStream_t stream) {
    constexpr unsigned per_block = refresh_threads * refresh_batch;
    permute_kernel<Unit, Units><<<(n * Units + per_block - 1) / per_block, refresh_threads, 0, stream>>>(
        n, slot, static_cast<const Unit*>(from), static_cast<Unit*>(to));
}

}  // namespace

void permute(std::uint32_t n, const std::uint32_t* slot, const void* from, void* to, int bytes_per_row,
             cudaStream_t stream) {
    if (n == 0) return;
    switch (bytes_per_row) {
        case 2:
            launch<std::uint16_t, 1>(n, slot, from, to, stream);
            break;
        case 4:
            launch<std::uint32_t, 1>(n, slot, from, to, stream);
            break;
        case 8:
            launch<std::uint64_t, 1>(n, slot, from, to, stream);
            break;
        case 16:
            launch<uint4, 1>(n, slot, from, to, stream);
            break;
        case 32:
            launch<uint4, 2>(n, slot, from, to, stream);
            break;
        default:
            throw std::logic_error("Rows of " + std::to_string(bytes_per_row) +
                                   " bytes cannot be permuted (2, 4, 8, 16 and 32 can). Add that size?");
    }
    check(cudaGetLastError(), "Permuting a column");
}

void renumber(std::uint32_t blocks, std::uint32_t words, const std::int32_t* old, const std::uint32_t* from,
              std::uint32_t* to, cudaStream_t stream) {
    if (blocks == 0) return;
    renumber_kernel<<<(blocks * words + refresh_threads - 1) / refresh_threads, refresh_threads, 0, stream>>>(
        blocks, words, old, from, to);
    check(cudaGetLastError(), "Numbering blocks anew");
}

void count_up(std::uint32_t n, std::uint32_t* slot, cudaStream_t stream, std::uint32_t start) {
    if (n == 0) return;
    number_kernel<<<(n + refresh_threads - 1) / refresh_threads, refresh_threads, 0, stream>>>(n, slot, start);
    check(cudaGetLastError(), "Counting up");
}

}  // namespace moraine::gpu
