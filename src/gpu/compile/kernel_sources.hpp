#pragma once
// The headers that device kernels are made of, as they were when this program was built: they travel in it, so that a
// run needs no source tree and no CUDA headers, and kernels always fit the host's code.

#include <cstdint>
#include <string_view>
#include <vector>

namespace moraine::gpu {

struct KernelSource {
    const char* name;  ///< as an #include names it
    const char* text;
};

/// All of them.
const std::vector<KernelSource>& kernel_sources();

/// Of names and texts.
std::uint64_t kernel_sources_hash();

}  // namespace moraine::gpu
