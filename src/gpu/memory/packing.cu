#include "gpu/memory/array.hpp"
#include "gpu/memory/packing.hpp"

namespace moraine::gpu {

namespace {

constexpr unsigned packing_threads = 256;

template <class Scalar, bool Pack>
__global__ void __launch_bounds__(packing_threads)
    packing_kernel(std::uint32_t n, const std::uint32_t* slot, RowPart part, Scalar* packed) {
    const std::uint32_t k = blockIdx.x * packing_threads + threadIdx.x;
    if (k >= n) return;
    Scalar* row = static_cast<Scalar*>(part.rows) + std::size_t(slot[k]) * std::size_t(part.row) + part.lane;
    Scalar* entry = packed + std::size_t(k) * std::size_t(part.stride) + part.offset;
    for (int i = 0; i < part.lanes; ++i) {
        if constexpr (Pack)
            entry[i] = row[i];
        else
            row[i] = entry[i];
    }
}

template <class Scalar, bool Pack>
void launch(std::uint32_t n, const std::uint32_t* slot, const RowPart& part, void* packed, cudaStream_t stream) {
    packing_kernel<Scalar, Pack><<<(n + packing_threads - 1) / packing_threads, packing_threads, 0, stream>>>(
        n, slot, part, static_cast<Scalar*>(packed));
}

template <bool Pack>
void copy(std::uint32_t n, const std::uint32_t* slot, const RowPart& part, void* packed, cudaStream_t stream) {
    if (n == 0) return;
    if (part.scalar_bytes == 8)
        launch<std::uint64_t, Pack>(n, slot, part, packed, stream);
    else if (part.scalar_bytes == 4)
        launch<std::uint32_t, Pack>(n, slot, part, packed, stream);
    else
        launch<std::uint16_t, Pack>(n, slot, part, packed, stream);
    check(cudaGetLastError(), "Packing a column");
}

}  // namespace

void pack_rows(std::uint32_t n, const std::uint32_t* slot, const RowPart& part, void* packed, cudaStream_t stream) {
    copy<true>(n, slot, part, packed, stream);
}

void unpack_rows(std::uint32_t n, const std::uint32_t* slot, const RowPart& part, const void* packed,
                 cudaStream_t stream) {
    copy<false>(n, slot, part, const_cast<void*>(packed), stream);
}

}  // namespace moraine::gpu
