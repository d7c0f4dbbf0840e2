#include <algorithm>

#include "gpu/kernels/cells/fill_lists.cuh"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

namespace {

constexpr unsigned threads = 32 * filing_warps;

/// Thread blocks that the device holds at once.
template <class Kernel>
unsigned resident(Kernel kernel) {
    int per_processor = 0, device = 0, processors = 0;
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&per_processor, kernel, threads, 0), "Filing");
    check(cudaGetDevice(&device), "Filing");
    check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device), "Filing");
    return static_cast<unsigned>(per_processor * processors);
}

unsigned grid_of(unsigned most, int blocks) {
    return std::clamp(static_cast<unsigned>((blocks + filing_warps - 1) / filing_warps), 1u, most);
}

/// From lengths in next_first to places.
template <int Dim>
void place(const Filing<Dim>& filing, cudaStream_t stream) {
    place_kernel<<<static_cast<unsigned>(filing_chunks(filing.table.own)), filing_chunk, 0, stream>>>(filing);
}

}  // namespace

template <int Dim>
void number_blocks(const Filing<Dim>& filing, cudaStream_t stream) {
    const auto chunks = static_cast<unsigned>(filing_chunks(filing.table.own));
    count_kernel<Dim, false><<<chunks, filing_chunk, 0, stream>>>(filing);
    place(filing, stream);
    check(cudaGetLastError(), "Numbering blocks");
}

template <int Dim>
void collect_leavers(const Filing<Dim>& filing, Part part, int blocks, cudaStream_t stream) {
    static const unsigned most = resident(collect_kernel<Dim>);
    if (filing.table.own == 0) return;
    collect_kernel<<<grid_of(most, blocks), threads, 0, stream>>>(filing, part);
    check(cudaGetLastError(), "Collecting leavers");
}

template <int Dim>
void make_lists(const Filing<Dim>& filing, cudaStream_t stream) {
    static const unsigned most = resident(fill_kernel<Dim>);
    count_kernel<Dim, true>
        <<<static_cast<unsigned>(filing_chunks(filing.table.own)), filing_chunk, 0, stream>>>(filing);
    place(filing, stream);
    if (filing.table.own > 0) fill_kernel<<<grid_of(most, filing.table.own), threads, 0, stream>>>(filing);
    check(cudaGetLastError(), "Filing");
}

template void number_blocks(const Filing<2>&, cudaStream_t);
template void number_blocks(const Filing<3>&, cudaStream_t);
template void collect_leavers(const Filing<2>&, Part, int, cudaStream_t);
template void collect_leavers(const Filing<3>&, Part, int, cudaStream_t);
template void make_lists(const Filing<2>&, cudaStream_t);
template void make_lists(const Filing<3>&, cudaStream_t);

}  // namespace moraine::gpu
