#include "gpu/array.hpp"
#include "gpu/nodes.cuh"

namespace moraine::gpu {

template <class Real, int Dim>
void solve_nodes(const View<Real, Dim>& view, const Stencil& stencil, const NodeRound<Real, Dim>& round,
                 const Quantum& quantum, cudaStream_t stream) {
    constexpr int blocks = node_threads / Block<Dim>::cells;
    const auto grid = static_cast<unsigned>((view.table.node_blocks + blocks - 1) / blocks);
    if (grid == 0) return;
    const NodeWork<Real, Dim> work{view, round, stencil.origin, quantum};
    if (stencil.width == 2)
        nodes_kernel<Real, Dim, 2><<<grid, node_threads, 0, stream>>>(work);
    else if (stencil.width == 3)
        nodes_kernel<Real, Dim, 3><<<grid, node_threads, 0, stream>>>(work);
    else
        nodes_kernel<Real, Dim, 4><<<grid, node_threads, 0, stream>>>(work);
    check(cudaGetLastError(), "Solving nodes");
}

template void solve_nodes(const View<float, 2>&, const Stencil&, const NodeRound<float, 2>&, const Quantum&,
                          cudaStream_t);
template void solve_nodes(const View<float, 3>&, const Stencil&, const NodeRound<float, 3>&, const Quantum&,
                          cudaStream_t);
template void solve_nodes(const View<double, 2>&, const Stencil&, const NodeRound<double, 2>&, const Quantum&,
                          cudaStream_t);
template void solve_nodes(const View<double, 3>&, const Stencil&, const NodeRound<double, 3>&, const Quantum&,
                          cudaStream_t);

}  // namespace moraine::gpu
