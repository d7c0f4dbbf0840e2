#include "gpu/kernels/nodes/device_structures.hpp"

#include <utility>

namespace moraine::gpu {

/// The host's values are copied before the call returns (less than 64 KiB, or the call waits).
template <int Dim>
ContactField<Dim> DeviceStructures<Dim>::place(const StructureSet<Dim>& structures, cudaStream_t stream) {
    ContactField<Dim> field = structures.field();
    if (!felt_.here) {
        values_.resize(structures.size());
        corners_.assign(field.corners, structures.corners());
        if (field.soil) soil_.assign(field.soil, structures.soil().size());
        felt_.make(structures.size());
        turning_.make(structures.any_turns() ? structures.size() : 0);
        empty_ = true;
    }
    check(cudaMemcpyAsync(values_.data(), field.structure, values_.size() * sizeof(Structure<Dim>),
                          cudaMemcpyHostToDevice, stream),
          "Copying structures to the device");
    if (empty_) empty(stream);
    field.structure = values_.data();
    field.corners = corners_.data();
    field.soil = field.soil ? soil_.data() : nullptr;
    field.sums = felt_.sums.data();
    field.turning = turning_.sums.data();
    return field;
}

template <int Dim>
void DeviceStructures<Dim>::empty(cudaStream_t stream) {
    felt_.empty(stream), turning_.empty(stream);
    empty_ = false;
}

template <int Dim>
void DeviceStructures<Dim>::fetch(cudaStream_t stream) {
    fetched_ = true;
    felt_.fetch(stream), turning_.fetch(stream);
}

template <int Dim>
void DeviceStructures<Dim>::take(std::vector<StructureSums<Dim>>& felt, std::vector<TurningSums<Dim>>& turning) {
    felt.clear(), turning.clear();
    if (!std::exchange(fetched_, false)) return;
    empty_ = true;
    felt.assign(felt_.here, felt_.here + felt_.sums.size());
    turning.assign(turning_.here, turning_.here + turning_.sums.size());
}

template class DeviceStructures<2>;
template class DeviceStructures<3>;

}  // namespace moraine::gpu
