#pragma once
// The structures on the device: their values go there each step, what they felt comes back with the step's report.

#include <cuda_runtime.h>

#include <vector>

#include "core/structures/structure_set.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

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
    /// What they feel from now on is summed anew; what was fetched can still be taken. Asynchronous.
    void empty(cudaStream_t stream);
    /// Of the steps since it was last taken; what fetch() queued must be done. Nothing where nothing was fetched since.
    std::vector<StructureSums<Dim>> take();

  private:
    Array<Structure<Dim>> values_;
    Array<Vec<double, 2>> corners_;
    Array<SoilShare> soil_;
    Array<StructureSums<Dim>> sums_;
    StructureSums<Dim>* felt_ = nullptr;  ///< pinned
    std::size_t count_ = 0;
    bool empty_ = false;    ///< the sums are to begin anew
    bool fetched_ = false;  ///< and not taken
};

}  // namespace moraine::gpu
