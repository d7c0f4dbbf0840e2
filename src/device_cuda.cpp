// The program with device code: which device a rank computes on.

#include <cuda_runtime.h>
#include <fmt/format.h>

#include "core/error.hpp"
#include "device.hpp"
#include "gpu/engine.hpp"

namespace moraine {

namespace {

/// This rank's place among those of its machine. Collective.
int local_rank(const Comm& comm) {
    MPI_Comm here = MPI_COMM_NULL;
    int rank = 0;
    MPI_Comm_split_type(comm.handle(), MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
    MPI_Comm_rank(here, &rank);
    MPI_Comm_free(&here);
    return rank;
}

int devices_here() {
    int n = 0;
    return cudaGetDeviceCount(&n) == cudaSuccess ? n : 0;
}

}  // namespace

DeviceChoice choose_device(const std::string& wanted, const Comm& comm) {
    if (wanted == "cpu") return {false, "Computing on the host (--device cpu)"};
    const int devices = devices_here();
    const bool all = comm.min(devices > 0 ? 1.0 : 0.0) > 0;
    if (!all && wanted == "cuda")
        throw InputError("No CUDA device was found (on at least one machine of the run). Use --device cpu?");
    if (!all) return {false, "Computing on the host (no CUDA device was found)"};
    const int mine = local_rank(comm) % devices;
    gpu::check(cudaSetDevice(mine), "Choosing a device");
    cudaDeviceProp properties{};
    gpu::check(cudaGetDeviceProperties(&properties, mine), "Asking the device");
    return {true, fmt::format("Computing on {} ({} rank{}, {} device{} on this machine)", properties.name, comm.size(),
                              comm.size() == 1 ? "" : "s", devices, devices == 1 ? "" : "s")};
}

template <class Real, int Dim>
DeviceEngineMaker<Real, Dim> device_engine_maker(const Scene& scene) {
    return [&](const Method<Host, Real, Dim>& method) {
        return std::make_unique<gpu::DeviceEngine<Real, Dim>>(scene, method);
    };
}

template DeviceEngineMaker<float, 2> device_engine_maker<float, 2>(const Scene&);
template DeviceEngineMaker<float, 3> device_engine_maker<float, 3>(const Scene&);
template DeviceEngineMaker<double, 2> device_engine_maker<double, 2>(const Scene&);
template DeviceEngineMaker<double, 3> device_engine_maker<double, 3>(const Scene&);

}  // namespace moraine
