#include "gpu/kernels/account.cuh"
#include "gpu/kernels/ends/ends.hpp"

namespace moraine::gpu {

namespace {

constexpr int end_threads = 128;

/// A thread per site.
template <class Real, int Dim>
__global__ void __launch_bounds__(end_threads, 1)
    ends_kernel(const __grid_constant__ ActAtEnds<Real, Dim> ends, const int count, const Quantum quantum,
                Account<Dim>* accounts) {
    const int i = static_cast<int>(blockIdx.x) * end_threads + static_cast<int>(threadIdx.x);
    ExactSum impulse[Dim];
    if (i < count) {
        ends(i);
        for (int a = 0; a < Dim; ++a) impulse[a] = quantum.of(ends.gifts[i].impulse[a]);
    }
    fold_sums(impulse, accounts[blockIdx.x % account_parts].impulse);
}

}  // namespace

template <class Real, int Dim>
void DeviceEnds<Real, Dim>::find(const Walls<Real, Dim>& walls, const bool (&absorbs)[Dim][2], int origin,
                                 std::span<const Vec<std::int32_t, Dim>> node_blocks, cudaStream_t stream) {
    if (laid_) return;
    laid_ = true;
    check(cudaStreamSynchronize(stream), "Waiting for the nodes of ends");
    const std::vector<EndSite<Real, Dim>> sites = end_sites(walls, absorbs, origin, node_blocks, measured_);
    sites_.assign(sites);
    gifts_.resize(sites.size());
}

template <class Real, int Dim>
void DeviceEnds<Real, Dim>::act(const View<Real, Dim>& view, int width, int origin, const NodeRound<Real, Dim>& round,
                                const Quantum& quantum, cudaStream_t stream) const {
    if (sites_.size() == 0) return;
    const ActAtEnds<Real, Dim> ends{view.context.walls, view.table,   view.grid, width, origin, round,
                                    sites_.data(),      gifts_.data()};
    const auto grid = static_cast<unsigned>((sites_.size() + end_threads - 1) / end_threads);
    ends_kernel<Real, Dim>
        <<<grid, end_threads, 0, stream>>>(ends, static_cast<int>(sites_.size()), quantum, view.accounts);
    check(cudaGetLastError(), "Acting at absorbing ends");
}

template class DeviceEnds<float, 2>;
template class DeviceEnds<float, 3>;
template class DeviceEnds<double, 2>;
template class DeviceEnds<double, 3>;

}  // namespace moraine::gpu
