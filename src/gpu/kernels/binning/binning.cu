#include <algorithm>

#include "gpu/kernels/binning/fill_lists.cuh"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

namespace {

constexpr unsigned threads = 32 * binning_warps;

/// Thread blocks that the device holds at once.
template <class Kernel>
unsigned resident(Kernel kernel) {
    int per_processor = 0, device = 0, processors = 0;
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&per_processor, kernel, threads, 0), "Binning");
    check(cudaGetDevice(&device), "Binning");
    check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device), "Binning");
    return static_cast<unsigned>(per_processor * processors);
}

unsigned grid_of(unsigned most, int blocks) {
    return std::clamp(static_cast<unsigned>((blocks + binning_warps - 1) / binning_warps), 1u, most);
}

/// From lengths in next_first to places.
template <int Dim>
void place(const Binning<Dim>& binning, cudaStream_t stream) {
    place_kernel<<<static_cast<unsigned>(binning_chunks(binning.table.own)), binning_chunk, 0, stream>>>(binning);
}

}  // namespace

template <int Dim>
void number_blocks(const Binning<Dim>& binning, cudaStream_t stream) {
    const auto chunks = static_cast<unsigned>(binning_chunks(binning.table.own));
    count_kernel<Dim, false><<<chunks, binning_chunk, 0, stream>>>(binning);
    place(binning, stream);
    check(cudaGetLastError(), "Numbering blocks");
}

template <int Dim>
void collect_outgoing(const Binning<Dim>& binning, Part part, int blocks, cudaStream_t stream) {
    static const unsigned most = resident(collect_kernel<Dim>);
    if (binning.table.own == 0) return;
    collect_kernel<<<grid_of(most, blocks), threads, 0, stream>>>(binning, part);
    check(cudaGetLastError(), "Collecting outgoing particles");
}

template <int Dim>
void make_lists(const Binning<Dim>& binning, cudaStream_t stream) {
    static const unsigned most = resident(fill_kernel<Dim>);
    count_kernel<Dim, true>
        <<<static_cast<unsigned>(binning_chunks(binning.table.own)), binning_chunk, 0, stream>>>(binning);
    place(binning, stream);
    if (binning.table.own > 0) fill_kernel<<<grid_of(most, binning.table.own), threads, 0, stream>>>(binning);
    check(cudaGetLastError(), "Binning");
}

template void number_blocks(const Binning<2>&, cudaStream_t);
template void number_blocks(const Binning<3>&, cudaStream_t);
template void collect_outgoing(const Binning<2>&, Part, int, cudaStream_t);
template void collect_outgoing(const Binning<3>&, Part, int, cudaStream_t);
template void make_lists(const Binning<2>&, cudaStream_t);
template void make_lists(const Binning<3>&, cudaStream_t);

}  // namespace moraine::gpu
