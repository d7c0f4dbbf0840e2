#pragma once
// Nodes on the device: from the sums in tiles to velocities, by the formula of core/nodes/nodes.hpp.
//
// A node is +0 plus its tiles in the order of the offset delta, as on the host. Every node block of the epoch has
// storage (node_of is the identity), so nothing has to be numbered; a node block that no occupied own block touches is
// skipped. Impulses of walls and damping are added exactly to the accounts, each node by the owner of the first
// occupied block whose tile covers it. Where structures are, the node blocks near them (near_blocks.hpp) have an
// instance of the kernel and a launch of their own.

#include "core/grid/shape.hpp"
#include "core/transfer/kernel_key.hpp"
#include "gpu/compile/kernel.hpp"
#include "gpu/kernels/nodes/node_work.hpp"

namespace moraine::gpu {

/// A kernel over node blocks: those that no structure is near, and those near one.
class NodeKernel {
  public:
    NodeKernel() = default;
    NodeKernel(Kernel plain, Kernel touching) : plain_(std::move(plain)), touching_(std::move(touching)) {}

    /// contact: there may be node blocks near a structure. Nothing is launched for none.
    void operator()(int node_blocks, int cells, const Argument& work, bool contact, cudaStream_t stream) const;

  private:
    Kernel plain_, touching_;
};

template <class Real, int Dim>
class Nodes {
  public:
    Nodes() = default;
    explicit Nodes(const KernelKey& key) : key_(key) {}

    /// `contact`: null where the scene has no structures. Light nodes are marked where `marks` has a place for that.
    void solve(const View<Real, Dim>& view, const Stencil& stencil, const NodeRound<Real, Dim>& round,
               const Quantum& quantum, const LightMarks<Real>& marks, cudaStream_t stream,
               const NodeContact<Dim>* contact = nullptr);
    /// The same, and what fluids want.
    void solve_fluid(const View<Real, Dim>& view, const Stencil& stencil, const NodeRound<Real, Dim>& round,
                     const Quantum& quantum, const LightMarks<Real>& marks, const NodeFluid<Real, Dim>& fluid,
                     cudaStream_t stream, const NodeContact<Dim>* contact = nullptr);

  private:
    const NodeKernel& kernel(bool marks, bool fluid);

    KernelKey key_;
    NodeKernel plain_, marking_, fluid_;
    bool has_plain_ = false, has_marking_ = false, has_fluid_ = false;
};

}  // namespace moraine::gpu
