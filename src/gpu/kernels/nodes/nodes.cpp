#include "gpu/kernels/nodes/nodes.hpp"

#include <algorithm>

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/lead/dt_places.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

namespace {

/// Node blocks of a launch that goes by the list of near ones: so many thread blocks take them in turn.
constexpr unsigned near_grid = 1024;

template <class Real, int Dim>
NodeWork<Real, Dim> work_of(const View<Real, Dim>& view, const Stencil& stencil, const NodeRound<Real, Dim>& round,
                            const Quantum& quantum, const LightMarks<Real>& marks, const NodeContact<Dim>* contact) {
    return {view, round, stencil.origin, quantum, marks, contact ? *contact : NodeContact<Dim>{}};
}

}  // namespace

void NodeKernel::operator()(int node_blocks, int cells, const Argument& work, bool contact, cudaStream_t stream) const {
    const int blocks = static_cast<int>(plain_.threads()) / cells;
    const auto grid = static_cast<unsigned>((node_blocks + blocks - 1) / blocks);
    if (grid == 0) return;
    plain_(grid, stream, {work}, "Solving nodes");
    if (contact) touching_(std::min(grid, near_grid), stream, {work}, "Solving nodes near structures");
}

template <class Real, int Dim>
const NodeKernel& Nodes<Real, Dim>::kernel(bool marks, bool fluid) {
    NodeKernel& mine = fluid ? fluid_ : marks ? marking_ : plain_;
    bool& known = fluid ? has_fluid_ : marks ? has_marking_ : has_plain_;
    if (!known) {
        const std::vector<Kernel>& kernels = KernelStore::instance().kernels(nodes_program(key_, marks, fluid));
        mine = {kernels[0], kernels.size() > 1 ? kernels[1] : Kernel()};
        known = true;
    }
    return mine;
}

template <class Real, int Dim>
void Nodes<Real, Dim>::solve(const View<Real, Dim>& view, const Stencil& stencil, const NodeRound<Real, Dim>& round,
                             const Quantum& quantum, const LightMarks<Real>& marks, cudaStream_t stream,
                             const NodeContact<Dim>* contact) {
    const NodeWork<Real, Dim> work = work_of(view, stencil, round, quantum, marks, contact);
    kernel(marks.of != nullptr, false)(view.table.node_blocks, Block<Dim>::cells, work, contact != nullptr, stream);
}

template <class Real, int Dim>
void Nodes<Real, Dim>::solve_fluid(const View<Real, Dim>& view, const Stencil& stencil,
                                   const NodeRound<Real, Dim>& round, const Quantum& quantum,
                                   const LightMarks<Real>& marks, const NodeFluid<Real, Dim>& fluid,
                                   cudaStream_t stream, const NodeContact<Dim>* contact) {
    const FluidNodeWork<Real, Dim> work{work_of(view, stencil, round, quantum, marks, contact), fluid};
    kernel(true, true)(view.table.node_blocks, Block<Dim>::cells, work, contact != nullptr, stream);
}

template <class Real, int Dim>
DtPlace dt_of_nodes() {
    using Work = NodeWork<Real, Dim>;
    return {offsetof(Work, round) + offsetof(decltype(Work::round), dt), sizeof(Work)};
}

#define MORAINE_NODES(Real, Dim)     \
    template class Nodes<Real, Dim>; \
    template DtPlace dt_of_nodes<Real, Dim>();
MORAINE_NODES(float, 2)
MORAINE_NODES(float, 3)
MORAINE_NODES(double, 2)
MORAINE_NODES(double, 3)

}  // namespace moraine::gpu
