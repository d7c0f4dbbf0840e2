#pragma once
// Nodes on the device: from the sums in tiles to velocities, by the formula of core/nodes.hpp.
//
// A node is +0 plus its tiles in the order of the offset delta, as on the host. Every node block of the epoch has
// storage (node_of is the identity), so nothing has to be numbered; a node block that no occupied own block touches is
// skipped. Impulses of walls and damping are added exactly to the accounts, each node by the owner of the first
// occupied block whose tile covers it. Where structures are, the node blocks near them (near_blocks.hpp) have an
// instance of the kernel and a launch of their own.

#include <cuda_runtime.h>

#include <vector>

#include "core/shape.hpp"
#include "core/structure_set.hpp"
#include "gpu/kernels/nodes/node_work.hpp"
#include "gpu/kernels/view.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

/// The structures on the device: their values go there each step, what they felt comes back with the step's report.
template <int Dim>
class DeviceStructures {
  public:
    DeviceStructures() = default;
    DeviceStructures(const DeviceStructures&) = delete;
    DeviceStructures& operator=(const DeviceStructures&) = delete;
    ~DeviceStructures() { cudaFreeHost(felt_); }

    /// Asynchronous.
    ContactField<Dim> place(const StructureSet<Dim>& structures, cudaStream_t stream);
    /// Queues the copy of what they felt so far. Asynchronous.
    void fetch(cudaStream_t stream);
    /// Of the steps since it was last taken; what fetch() queued must be done.
    std::vector<StructureSums<Dim>> take();

  private:
    Array<Structure<Dim>> values_;
    Array<Vec<double, 2>> corners_;
    Array<StructureSums<Dim>> sums_;
    StructureSums<Dim>* felt_ = nullptr;  ///< pinned
    std::size_t count_ = 0;
    bool empty_ = false;  ///< the sums are to begin anew
};

/// `contact`: null where the scene has no structures.
template <class Real, int Dim>
void solve_nodes(const View<Real, Dim>& view, const Stencil& stencil, const NodeRound<Real, Dim>& round,
                 const Quantum& quantum, const LightMarks<Real>& marks, cudaStream_t stream,
                 const NodeContact<Dim>* contact = nullptr);

/// The same, and what fluids want.
template <class Real, int Dim>
void solve_fluid_nodes(const View<Real, Dim>& view, const Stencil& stencil, const NodeRound<Real, Dim>& round,
                       const Quantum& quantum, const LightMarks<Real>& marks, const NodeFluid<Real, Dim>& fluid,
                       cudaStream_t stream, const NodeContact<Dim>* contact = nullptr);

}  // namespace moraine::gpu
