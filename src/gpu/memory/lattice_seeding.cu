#include "gpu/memory/lattice_rows.hpp"
#include "gpu/memory/lattice_seeding.hpp"

namespace moraine::gpu {

namespace {

constexpr unsigned seeding_threads = 128;

/// A thread block per block: bounds of its cells, then a thread per particle.
template <class Real, int Dim>
__global__ void __launch_bounds__(seeding_threads)
    seeding_kernel(LatticeView<Real, Dim> lattice, const Vec<std::int32_t, Dim>* position, const std::uint32_t* first,
                   Columns<Real, Dim> to) {
    constexpr int cells = Block<Dim>::cells;
    __shared__ std::uint32_t bound[cells + 1];
    const std::uint32_t start = first[blockIdx.x], count = first[blockIdx.x + 1] - start;
    if (count == 0) return;
    const Vec<std::int32_t, Dim> at = position[blockIdx.x];
    const int thread = static_cast<int>(threadIdx.x);
    if (thread == 0) bound[0] = 0;
    if (thread < cells) bound[thread + 1] = lattice.count(at, thread);
    __syncthreads();
    for (int c = 0; thread == 0 && c < cells; ++c) bound[c + 1] += bound[c];
    __syncthreads();
    for (std::uint32_t k = threadIdx.x; k < count; k += seeding_threads) {
        const int cell = cell_at<Dim>(bound, k);
        put_rows(lattice.particle(at, cell, k - bound[cell]), to, start + k);
    }
}

}  // namespace

template <class Real, int Dim>
void seed_blocks(int own, const LatticeView<Real, Dim>& lattice, const Vec<std::int32_t, Dim>* position,
                 const std::uint32_t* first, const Columns<Real, Dim>& to, cudaStream_t stream) {
    if (own == 0) return;
    seeding_kernel<<<static_cast<unsigned>(own), seeding_threads, 0, stream>>>(lattice, position, first, to);
    check(cudaGetLastError(), "Seeding");
}

#define MORAINE_SEED_BLOCKS(Real, Dim)                                                                                 \
    template void seed_blocks(int, const LatticeView<Real, Dim>&, const Vec<std::int32_t, Dim>*, const std::uint32_t*, \
                              const Columns<Real, Dim>&, cudaStream_t);
MORAINE_SEED_BLOCKS(float, 2)
MORAINE_SEED_BLOCKS(float, 3)
MORAINE_SEED_BLOCKS(double, 2)
MORAINE_SEED_BLOCKS(double, 3)
#undef MORAINE_SEED_BLOCKS

}  // namespace moraine::gpu
