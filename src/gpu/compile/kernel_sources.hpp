#pragma once
// The headers that device kernels are made of. A run needs no CUDA headers.

#include "compile/source_bundle.hpp"

namespace moraine::gpu {

/// All of them.
const SourceBundle& kernel_sources();

}  // namespace moraine::gpu
