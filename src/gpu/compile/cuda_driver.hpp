#pragma once
// Entry points of the CUDA driver that the runtime has no name for in all versions: asked for by name, so that nothing
// is linked to the driver, which login nodes lack.

#include <cuda.h>

namespace moraine::gpu {

struct Driver {
    decltype(&::cuLibraryLoadData) load_library;
    decltype(&::cuLibraryGetKernel) kernel_of_library;
    decltype(&::cuLibraryGetGlobal) global_of_library;
    decltype(&::cuKernelGetFunction) function_of_kernel;
    decltype(&::cuFuncSetAttribute) set_attribute;
    decltype(&::cuFuncGetParamInfo) parameter;
    decltype(&::cuLaunchKernel) launch;
    decltype(&::cuGraphKernelNodeGetParams_v2) parameters_of_node;
    decltype(&::cuGetErrorString) error_string;

    /// Of the process. Throws MachineError where the driver is older than CUDA 12.4.
    static const Driver& instance();
};

/// Throws MachineError `what failed (CUDA's message). ...`.
void check(CUresult result, const char* what);

}  // namespace moraine::gpu
