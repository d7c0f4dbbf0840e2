#pragma once
// Launching a kernel whose teams take chosen blocks in turn.

#include "gpu/kernels/launch.hpp"
#include "gpu/kernels/team.cuh"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

/// A kernel and the shared memory of its teams. Made once: asks the device for more than 48 KiB where it needs that.
template <int Dim, class... Parameters>
class TeamKernel {
  public:
    using Function = void (*)(Parameters...);

    TeamKernel(Function function, std::size_t bytes_per_team, const char* name)
        : function_(function), bytes_(bytes_per_team * Team<Dim>::per_block), name_(name) {
        check(cudaFuncSetAttribute(function, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes_)),
              name);
    }

    template <class... Arguments>
    void operator()(const Launch& launch, const Arguments&... arguments) const {
        constexpr int teams = Team<Dim>::per_block;
        const int grid = launch.blocks > teams ? (launch.blocks + teams - 1) / teams : 1;
        function_<<<static_cast<unsigned>(grid), Team<Dim>::block_threads, bytes_, launch.stream>>>(arguments...);
        check(cudaGetLastError(), name_);
    }

  private:
    Function function_;
    std::size_t bytes_;
    const char* name_;
};

}  // namespace moraine::gpu
