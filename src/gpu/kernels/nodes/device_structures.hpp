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
    ~DeviceStructures() { cudaFreeHost(felt_.here), cudaFreeHost(turning_.here); }

    /// Asynchronous.
    ContactField<Dim> place(const StructureSet<Dim>& structures, cudaStream_t stream);
    /// Queues the copy of what they felt so far. Asynchronous.
    void fetch(cudaStream_t stream);
    /// What they feel from now on is summed anew; what was fetched can still be taken. Asynchronous.
    void empty(cudaStream_t stream);
    /// Of the steps since it was last taken; what fetch() queued must be done. Nothing where nothing was fetched since,
    /// and of turning nothing where no structure turns.
    void take(std::vector<StructureSums<Dim>>& felt, std::vector<TurningSums<Dim>>& turning);

  private:
    /// Sums on the device and where they come back.
    template <class Sums>
    struct Returned {
        Array<Sums> sums;
        Sums* here = nullptr;  ///< pinned

        void make(std::size_t count) {
            sums.resize(count);
            if (count > 0) check(cudaHostAlloc(&here, count * sizeof(Sums), 0), "Allocating pinned memory");
        }
        void empty(cudaStream_t stream) {
            if (sums.size() > 0)
                check(cudaMemsetAsync(sums.data(), 0, sums.size() * sizeof(Sums), stream), "Emptying sums");
        }
        void fetch(cudaStream_t stream) {
            if (sums.size() > 0)
                check(cudaMemcpyAsync(here, sums.data(), sums.size() * sizeof(Sums), cudaMemcpyDeviceToHost, stream),
                      "Copying what structures felt");
        }
    };

    Array<Structure<Dim>> values_;
    Array<Vec<double, 2>> corners_;
    Array<SoilShare> soil_;
    Returned<StructureSums<Dim>> felt_;
    Returned<TurningSums<Dim>> turning_;  ///< none where no structure turns
    bool empty_ = false;                  ///< the sums are to begin anew
    bool fetched_ = false;                ///< and not taken
};

}  // namespace moraine::gpu
