#pragma once
// Flags in device memory by which streams of several processes wait for each other.

#include <cuda_runtime.h>

#include <cstdint>

namespace moraine::gpu {

/// *flags[k] = value for k < n, once all earlier work of the stream is visible to every device. Asynchronous.
void raise_flags(std::uint32_t* const* flags, int n, std::uint32_t value, cudaStream_t stream);

/// Later work of the stream waits until *flag, on this device, has reached `value`. Asynchronous; no thread spins.
void wait_for_flag(const std::uint32_t* flag, std::uint32_t value, cudaStream_t stream);

}  // namespace moraine::gpu
