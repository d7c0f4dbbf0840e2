#include "gpu/kernels/nodes/device_structures.hpp"

#include <utility>

namespace moraine::gpu {

/// The host's values are copied before the call returns (less than 64 KiB, or the call waits).
template <int Dim>
ContactField<Dim> DeviceStructures<Dim>::place(const StructureSet<Dim>& structures, cudaStream_t stream) {
    ContactField<Dim> field = structures.field();
    if (!felt_) {
        count_ = structures.size();
        values_.resize(count_);
        sums_.resize(count_);
        corners_.assign(field.corners, structures.corners());
        if (field.soil) soil_.assign(field.soil, structures.soil().size());
        check(cudaHostAlloc(&felt_, count_ * sizeof(StructureSums<Dim>), 0), "Allocating pinned memory");
        empty_ = true;
    }
    check(cudaMemcpyAsync(values_.data(), field.structure, count_ * sizeof(Structure<Dim>), cudaMemcpyHostToDevice,
                          stream),
          "Copying structures to the device");
    if (empty_) empty(stream);
    field.structure = values_.data();
    field.corners = corners_.data();
    field.soil = field.soil ? soil_.data() : nullptr;
    field.sums = sums_.data();
    return field;
}

template <int Dim>
void DeviceStructures<Dim>::empty(cudaStream_t stream) {
    check(cudaMemsetAsync(sums_.data(), 0, count_ * sizeof(StructureSums<Dim>), stream), "Emptying sums");
    empty_ = false;
}

template <int Dim>
void DeviceStructures<Dim>::fetch(cudaStream_t stream) {
    fetched_ = true;
    check(cudaMemcpyAsync(felt_, sums_.data(), count_ * sizeof(StructureSums<Dim>), cudaMemcpyDeviceToHost, stream),
          "Copying what structures felt");
}

template <int Dim>
std::vector<StructureSums<Dim>> DeviceStructures<Dim>::take() {
    if (!std::exchange(fetched_, false)) return {};
    empty_ = true;
    return {felt_, felt_ + count_};
}

template class DeviceStructures<2>;
template class DeviceStructures<3>;

}  // namespace moraine::gpu
