#pragma once
// Where a run computes: on the host or on CUDA devices, one per rank. A program without device code has the host only.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "comm/comm.hpp"
#include "comm/phases.hpp"
#include "engine/engine.hpp"

namespace moraine {

namespace gpu {
class TransportFactory;
}

struct DeviceChoice {
    bool cuda = false;
    std::string message;                                      ///< for the user: what was chosen, and why
    std::shared_ptr<const gpu::TransportFactory> transports;  ///< between devices; none: one rank, or the host
    std::string transport = "host";
    int refresh_interval = 0;  ///< of a device's memory [steps]; 0: by what the particles take
};

/// Whether choose_device() would take CUDA: says so before anything is tried. Collective.
bool wants_device(const std::string& wanted, const Comm& comm);

/// `wanted` is --device: cpu, cuda, or auto (CUDA where every rank finds a device). The ranks of a machine are given
/// its devices in turn. `transport` is --transport: auto, or one of comm/transport_names.hpp; tried before it is
/// chosen. Throws InputError, the same on all ranks, where what is wanted cannot be had. Collective.
DeviceChoice choose_device(const std::string& wanted, const Comm& comm, const std::string& transport = "auto");

/// Where compiled device kernels are kept (--kernel-cache); tells: that some are being compiled is said on stderr.
void keep_kernels(const std::string& folder, bool tells);

/// Compiles the device kernels of a scene into that folder, for these compute capabilities (times 10; none: that of the
/// build). Returns what to say of it. Needs no device. Throws MachineError; InputError where there is no device code.
std::string compile_kernels(const Scene& scene, const std::string& folder, const std::vector<int>& architectures);

/// Throws InputError, the same on all ranks, if a device has less free than its ranks need, `bytes` each. Collective.
void check_device_memory(double bytes, const Comm& comm);

/// Ranges of NVTX for profilers of devices, on hosts too; none where there is no device code.
Profiler device_profiler();

template <class Real, int Dim>
using DeviceEngineMaker = std::function<std::unique_ptr<Engine<Real, Dim>>(const Method<Host, Real, Dim>&)>;

/// Makes engines on the device that choose_device() gave to this rank. All must outlive what is made.
template <class Real, int Dim>
DeviceEngineMaker<Real, Dim> device_engine_maker(const Scene& scene, const Comm& comm, const DeviceChoice& choice);

}  // namespace moraine
