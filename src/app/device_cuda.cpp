// The program with device code: which device a rank computes on.

#include <cuda_runtime.h>
#include <fmt/format.h>
#include <malloc.h>
#include <nvtx3/nvToolsExt.h>

#include <cmath>
#include <filesystem>

#include "app/device.hpp"
#include "core/data/error.hpp"
#include "gpu/compile/kernel_store.hpp"
#include "gpu/engine.hpp"
#include "gpu/kernels/programs.hpp"
#include "gpu/transport/transport.hpp"

namespace moraine {

namespace {

int devices_here() {
    int n = 0;
    return cudaGetDeviceCount(&n) == cudaSuccess ? n : 0;
}

/// The host of a device makes tables of some MB again and again: giving them back costs as much as filling them.
void keep_freed_memory() {
    mallopt(M_MMAP_THRESHOLD, 1 << 25);
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
}

}  // namespace

bool wants_device(const std::string& wanted, const Comm& comm) {
    return wanted == "cuda" || (wanted == "auto" && comm.min(devices_here() > 0 ? 1.0 : 0.0) > 0);
}

DeviceChoice choose_device(const std::string& wanted, const Comm& comm, const std::string& transport) {
    const auto host = [&](const char* why) {
        if (transport != "auto" && transport != "host")
            throw InputError(
                fmt::format("--transport {} moves device memory ({}). Use --transport host?", transport, why));
        return DeviceChoice{false, std::string("Computing on the host (") + why + ")", nullptr, "host"};
    };
    if (wanted == "cpu") return host("--device cpu");
    const int devices = devices_here();
    const bool all = comm.min(devices > 0 ? 1.0 : 0.0) > 0;
    if (!all && wanted == "cuda")
        throw InputError("No CUDA device was found (--device cuda needs one on every machine). Use --device cpu?");
    if (!all) return host("no CUDA device was found");
    const int mine = comm.on_this_machine().rank % devices;
    gpu::check(cudaSetDevice(mine), "Choosing a device");
    cudaDeviceProp properties{};
    gpu::check(cudaGetDeviceProperties(&properties, mine), "Asking the device");
    DeviceChoice choice{true, {}, nullptr, "none"};
    std::string how;
    if (comm.size() > 1) {
        choice.transports = gpu::choose_transport(comm, transport, how);
        choice.transport = choice.transports->name();
    }
    keep_freed_memory();
    choice.message =
        fmt::format("Computing on {} ({} rank{}, {} device{} on this machine){}{}", properties.name, comm.size(),
                    comm.size() == 1 ? "" : "s", devices, devices == 1 ? "" : "s", how.empty() ? "" : ", ", how);
    return choice;
}

namespace {

/// Kernels that a package brings: ../share/moraine/kernels beside the program.
std::vector<std::filesystem::path> packaged_kernels() {
    std::error_code failed;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failed);
    if (failed) return {};
    return {program.parent_path().parent_path() / "share/moraine/kernels"};
}

CompileCache kernel_cache(const std::string& folder) {
    return CompileCache(kernel_cache_folder(folder), packaged_kernels());
}

void say(const std::string& words) {
    fmt::print(stderr, "{}\n", words);
}

}  // namespace

void keep_kernels(const std::string& folder, bool tells) {
    gpu::KernelStore::instance().keep_in(kernel_cache(folder), tells ? say : nullptr);
}

std::string compile_kernels(const Scene& scene, const std::string& folder, const std::vector<int>& architectures) {
    const CompileCache cache = kernel_cache(folder);
    if (cache.folder().empty())
        throw InputError("No folder for kernels (--kernel-cache none keeps nothing). Name one?");
    const KernelKey key = kernel_key(scene);
    const gpu::Program program = gpu::merged(gpu::programs_of(key));
    for (const int architecture : architectures.empty() ? std::vector<int>{MORAINE_ARCHITECTURE} : architectures)
        gpu::compile_to_disk(cache, program, architecture, say);
    return fmt::format("{}: {} kernels in {} ({})\n", scene.source.path, program.kernels.size(),
                       cache.folder().string(), key.text());
}

void check_device_memory(double bytes, const Comm& comm) {
    std::size_t free = 0, total = 0;
    gpu::check(cudaMemGetInfo(&free, &total), "Asking the device for its memory");
    const int sharing = (comm.on_this_machine().size + devices_here() - 1) / devices_here();  // ranks of one device
    const double mine = bytes * sharing, all = bytes * comm.size();
    std::string wrong;
    if (mine > static_cast<double>(free))
        wrong = fmt::format(
            "The scene needs {:.1f} GB of device memory, {:.1f} GB on each device ({:.1f} of {:.1f} GB are "
            "free). {} such GPUs would hold it; a larger domain.cell, single precision or --device cpu?",
            all * 1e-9, mine * 1e-9, static_cast<double>(free) * 1e-9, static_cast<double>(total) * 1e-9,
            static_cast<int>(std::ceil(all / (0.95 * static_cast<double>(total)))));
    comm.agree_no_error<InputError>(wrong);
}

Profiler device_profiler() {
    return {[](const char* name) { nvtxRangePushA(name); }, [] { nvtxRangePop(); }};
}

template <class Real, int Dim>
DeviceEngineMaker<Real, Dim> device_engine_maker(const Scene& scene, const Comm& comm, const DeviceChoice& choice) {
    return [&scene, &comm, transports = choice.transports,
            interval = choice.refresh_interval](const Method<Host, Real, Dim>& method) {
        return std::make_unique<gpu::DeviceEngine<Real, Dim>>(scene, comm, method, transports.get(), interval);
    };
}

template DeviceEngineMaker<float, 2> device_engine_maker<float, 2>(const Scene&, const Comm&, const DeviceChoice&);
template DeviceEngineMaker<float, 3> device_engine_maker<float, 3>(const Scene&, const Comm&, const DeviceChoice&);
template DeviceEngineMaker<double, 2> device_engine_maker<double, 2>(const Scene&, const Comm&, const DeviceChoice&);
template DeviceEngineMaker<double, 3> device_engine_maker<double, 3>(const Scene&, const Comm&, const DeviceChoice&);

}  // namespace moraine
