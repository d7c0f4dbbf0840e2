#include "gpu/compile/cuda_driver.hpp"

#include <cuda_runtime_api.h>

#include <string>
#include <type_traits>

#include "core/data/rank_failure.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

namespace {

template <class F>
void take(F& function, const char* name) {
    void* found = nullptr;
    cudaDriverEntryPointQueryResult how{};
#if CUDART_VERSION >= 12050
    check(cudaGetDriverEntryPointByVersion(name, &found, 12040, cudaEnableDefault, &how), "Asking the driver");
#else
    check(cudaGetDriverEntryPoint(name, &found, cudaEnableDefault, &how), "Asking the driver");
#endif
    if (how != cudaDriverEntryPointSuccess || !found)
        throw MachineError(std::string("The CUDA driver has no ") + name + ". Is it of CUDA 12.4 or newer?");
    function = reinterpret_cast<F>(found);
}

}  // namespace

const Driver& Driver::instance() {
    static const Driver driver = [] {
        Driver d{};
        take(d.load_library, "cuLibraryLoadData");
        take(d.kernel_of_library, "cuLibraryGetKernel");
        take(d.global_of_library, "cuLibraryGetGlobal");
        take(d.function_of_kernel, "cuKernelGetFunction");
        take(d.set_attribute, "cuFuncSetAttribute");
        take(d.parameter, "cuFuncGetParamInfo");
        take(d.launch, "cuLaunchKernel");
        take(d.parameters_of_node, "cuGraphKernelNodeGetParams");
        take(d.error_string, "cuGetErrorString");
        return d;
    }();
    return driver;
}

void check(CUresult result, const char* what) {
    if (result == CUDA_SUCCESS) return;
    const char* words = nullptr;
    Driver::instance().error_string(result, &words);
    throw RankFailure(std::string(what) + " failed (" + (words ? words : "unknown error") +
                      "). Is the device in order?");
}

}  // namespace moraine::gpu
