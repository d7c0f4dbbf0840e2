#include "gpu/memory/array.hpp"
#include "gpu/memory/packing.hpp"

namespace moraine::gpu {

namespace {

constexpr unsigned packing_threads = 256;

template <class Scalar, bool Gather>
__global__ void __launch_bounds__(packing_threads)
    packing_kernel(std::uint32_t n, const std::uint32_t* slot, Piece piece, Scalar* packed) {
    const std::uint32_t k = blockIdx.x * packing_threads + threadIdx.x;
    if (k >= n) return;
    Scalar* row = static_cast<Scalar*>(piece.rows) + std::size_t(slot[k]) * std::size_t(piece.row) + piece.lane;
    Scalar* entry = packed + std::size_t(k) * std::size_t(piece.stride) + piece.offset;
    for (int i = 0; i < piece.lanes; ++i) {
        if constexpr (Gather)
            entry[i] = row[i];
        else
            row[i] = entry[i];
    }
}

template <class Scalar, bool Gather>
void launch(std::uint32_t n, const std::uint32_t* slot, const Piece& piece, void* packed, cudaStream_t stream) {
    packing_kernel<Scalar, Gather><<<(n + packing_threads - 1) / packing_threads, packing_threads, 0, stream>>>(
        n, slot, piece, static_cast<Scalar*>(packed));
}

template <bool Gather>
void copy(std::uint32_t n, const std::uint32_t* slot, const Piece& piece, void* packed, cudaStream_t stream) {
    if (n == 0) return;
    if (piece.scalar_bytes == 8)
        launch<std::uint64_t, Gather>(n, slot, piece, packed, stream);
    else if (piece.scalar_bytes == 4)
        launch<std::uint32_t, Gather>(n, slot, piece, packed, stream);
    else
        launch<std::uint16_t, Gather>(n, slot, piece, packed, stream);
    check(cudaGetLastError(), "Packing a column");
}

}  // namespace

void gather_rows(std::uint32_t n, const std::uint32_t* slot, const Piece& piece, void* packed, cudaStream_t stream) {
    copy<true>(n, slot, piece, packed, stream);
}

void scatter_rows(std::uint32_t n, const std::uint32_t* slot, const Piece& piece, const void* packed,
                  cudaStream_t stream) {
    copy<false>(n, slot, piece, const_cast<void*>(packed), stream);
}

}  // namespace moraine::gpu
