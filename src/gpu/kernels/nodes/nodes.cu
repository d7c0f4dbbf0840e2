#include "gpu/kernels/lead/dt_places.hpp"
#include "gpu/kernels/nodes/nodes.cuh"
#include "gpu/kernels/nodes/nodes.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
void solve_nodes(const View<Real, Dim>& view, const Stencil& stencil, const NodeRound<Real, Dim>& round,
                 const Quantum& quantum, const LightMarks<Real>& marks, cudaStream_t stream,
                 const NodeContact<Dim>* contact) {
    const NodeWork<Real, Dim> work{view,    round, stencil.origin,
                                   quantum, marks, contact ? *contact : NodeContact<Dim>{}};
    marks.of ? run_nodes<Real, Dim, true, false>(work, stencil.width, contact != nullptr, stream)
             : run_nodes<Real, Dim, false, false>(work, stencil.width, contact != nullptr, stream);
}

template <class Real, int Dim>
DtPlace dt_of_nodes() {
    using Work = NodeWork<Real, Dim>;
    return {offsetof(Work, round) + offsetof(decltype(Work::round), dt), sizeof(Work)};
}

/// The host's values are copied before the call returns (less than 64 KiB, or the call waits).
template <int Dim>
ContactField<Dim> DeviceStructures<Dim>::place(const StructureSet<Dim>& structures, cudaStream_t stream) {
    ContactField<Dim> field = structures.field();
    if (!felt_) {
        count_ = structures.size();
        values_.resize(count_);
        sums_.resize(count_);
        corners_.assign(field.corners, structures.corners());
        check(cudaHostAlloc(&felt_, count_ * sizeof(StructureSums<Dim>), 0), "Allocating pinned memory");
        empty_ = true;
    }
    check(cudaMemcpyAsync(values_.data(), field.structure, count_ * sizeof(Structure<Dim>), cudaMemcpyHostToDevice,
                          stream),
          "Copying structures to the device");
    if (empty_) check(cudaMemsetAsync(sums_.data(), 0, count_ * sizeof(StructureSums<Dim>), stream), "Emptying sums");
    empty_ = false;
    field.structure = values_.data();
    field.corners = corners_.data();
    field.sums = sums_.data();
    return field;
}

template <int Dim>
void DeviceStructures<Dim>::fetch(cudaStream_t stream) {
    check(cudaMemcpyAsync(felt_, sums_.data(), count_ * sizeof(StructureSums<Dim>), cudaMemcpyDeviceToHost, stream),
          "Copying what structures felt");
}

template <int Dim>
std::vector<StructureSums<Dim>> DeviceStructures<Dim>::take() {
    empty_ = true;
    return {felt_, felt_ + count_};
}

template DtPlace dt_of_nodes<float, 2>();
template DtPlace dt_of_nodes<float, 3>();
template DtPlace dt_of_nodes<double, 2>();
template DtPlace dt_of_nodes<double, 3>();
template class DeviceStructures<2>;
template class DeviceStructures<3>;
template void solve_nodes(const View<float, 2>&, const Stencil&, const NodeRound<float, 2>&, const Quantum&,
                          const LightMarks<float>&, cudaStream_t, const NodeContact<2>*);
template void solve_nodes(const View<float, 3>&, const Stencil&, const NodeRound<float, 3>&, const Quantum&,
                          const LightMarks<float>&, cudaStream_t, const NodeContact<3>*);
template void solve_nodes(const View<double, 2>&, const Stencil&, const NodeRound<double, 2>&, const Quantum&,
                          const LightMarks<double>&, cudaStream_t, const NodeContact<2>*);
template void solve_nodes(const View<double, 3>&, const Stencil&, const NodeRound<double, 3>&, const Quantum&,
                          const LightMarks<double>&, cudaStream_t, const NodeContact<3>*);

}  // namespace moraine::gpu
