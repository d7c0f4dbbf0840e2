#pragma once
// Nodes on the device: from the sums in tiles to velocities, by the formula of core/nodes.hpp.
//
// A node is +0 plus its tiles in the order of the offset delta, as on the host. Every node block of the epoch has
// storage (node_of is the identity), so nothing has to be numbered; a node block that no occupied own block touches is
// skipped. Impulses of walls and damping are added exactly to the accounts, each node by the owner of the first
// occupied block whose tile covers it.

#include <cuda_runtime.h>

#include "core/nodes.hpp"
#include "core/shape.hpp"
#include "gpu/view.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
void solve_nodes(const View<Real, Dim>& view, const Stencil& stencil, const NodeRound<Real, Dim>& round,
                 const Quantum& quantum, cudaStream_t stream);

}  // namespace moraine::gpu
