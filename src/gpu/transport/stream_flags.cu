#include <cuda.h>

#include "core/data/rank_failure.hpp"
#include "gpu/memory/array.hpp"
#include "gpu/transport/stream_flags.hpp"

namespace moraine::gpu {

namespace {

__global__ void __launch_bounds__(32) raise_kernel(std::uint32_t* const* flags, int n, std::uint32_t value) {
    __threadfence_system();
    for (int k = static_cast<int>(threadIdx.x); k < n; k += 32)
        asm volatile("st.release.sys.global.u32 [%0], %1;" ::"l"(flags[k]), "r"(value) : "memory");
}

using WaitValue = CUresult (*)(CUstream, CUdeviceptr, cuuint32_t, unsigned int);

/// The driver's function, without linking the driver: the program must start where there is none.
WaitValue wait_value() {
    void* function = nullptr;
    cudaDriverEntryPointQueryResult found{};
#if CUDART_VERSION >= 12050
    check(cudaGetDriverEntryPointByVersion("cuStreamWaitValue32", &function, 12000, cudaEnableDefault, &found),
          "Asking the driver");
#else
    check(cudaGetDriverEntryPoint("cuStreamWaitValue32", &function, cudaEnableDefault, &found), "Asking the driver");
#endif
    if (found != cudaDriverEntryPointSuccess || !function)
        throw MachineError("The driver has no cuStreamWaitValue32 (CUDA 12 has). Use --transport host?");
    return reinterpret_cast<WaitValue>(function);
}

}  // namespace

void raise_flags(std::uint32_t* const* flags, int n, std::uint32_t value, cudaStream_t stream) {
    if (n == 0) return;
    raise_kernel<<<1, 32, 0, stream>>>(flags, n, value);
    check(cudaGetLastError(), "Telling peers of a message");
}

void wait_for_flag(const std::uint32_t* flag, std::uint32_t value, cudaStream_t stream) {
    static const WaitValue wait = wait_value();
    if (wait(stream, reinterpret_cast<CUdeviceptr>(flag), value, CU_STREAM_WAIT_VALUE_GEQ) != CUDA_SUCCESS)
        throw RankFailure("Waiting for a peer's message failed (cuStreamWaitValue32). Use --transport host?");
}

}  // namespace moraine::gpu
