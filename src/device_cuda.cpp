// The program with device code: which device a rank computes on.

#include <cuda_runtime.h>
#include <fmt/format.h>

#include <cmath>

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
    if (comm.size() > 1 && wanted == "cuda")
        throw InputError(
            fmt::format("{} ranks with --device cuda (the halo of devices is not there yet). Use one rank, or "
                        "--device cpu?",
                        comm.size()));
    if (comm.size() > 1) return {false, "Computing on the host (a device serves runs of one rank so far)"};
    const int devices = devices_here();
    const bool all = comm.min(devices > 0 ? 1.0 : 0.0) > 0;
    if (!all && wanted == "cuda")
        throw InputError("No CUDA device was found (--device cuda needs one on every machine). Use --device cpu?");
    if (!all) return {false, "Computing on the host (no CUDA device was found)"};
    const int mine = local_rank(comm) % devices;
    gpu::check(cudaSetDevice(mine), "Choosing a device");
    cudaDeviceProp properties{};
    gpu::check(cudaGetDeviceProperties(&properties, mine), "Asking the device");
    return {true, fmt::format("Computing on {} ({} rank{}, {} device{} on this machine)", properties.name, comm.size(),
                              comm.size() == 1 ? "" : "s", devices, devices == 1 ? "" : "s")};
}

void check_device_memory(double bytes) {
    std::size_t free = 0, total = 0;
    gpu::check(cudaMemGetInfo(&free, &total), "Asking the device for its memory");
    if (bytes <= static_cast<double>(free)) return;
    throw InputError(
        fmt::format("The scene needs {:.1f} GB of device memory ({:.1f} of {:.1f} GB are free). {} such GPUs "
                    "would hold it; a larger domain.cell, single precision or --device cpu?",
                    bytes * 1e-9, static_cast<double>(free) * 1e-9, static_cast<double>(total) * 1e-9,
                    static_cast<int>(std::ceil(bytes / (0.95 * static_cast<double>(total))))));
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
