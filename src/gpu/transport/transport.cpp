#include "gpu/transport/transport.hpp"

#include <cstring>

#include "gpu/memory/array.hpp"
#include "gpu/transport/mpi_transport.hpp"
#include "gpu/transport/nccl_transport.hpp"
#include "gpu/transport/peer_transport.hpp"
#include "gpu/transport/transport_trial.hpp"

namespace moraine::gpu {

namespace {

bool on_one_host(const Comm& comm) {
    return comm.min(comm.on_this_machine().size == comm.size() ? 1.0 : 0.0) > 0;
}

/// Whether two ranks compute on one device.
bool devices_are_shared(const Comm& comm) {
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "Asking for the device");
    check(cudaGetDeviceProperties(&properties, device), "Asking the device");
    const std::vector<cudaUUID_t> all = comm.all_gather(std::vector<cudaUUID_t>{properties.uuid});
    int same = 0;
    for (const cudaUUID_t& other : all) same += std::memcmp(&other, &properties.uuid, sizeof(other)) == 0;
    return comm.max(static_cast<double>(same)) > 1;
}

/// Why a kind of wire cannot be had, without trying it; empty: it can be tried. Collective.
std::string obstacle(const Comm& comm, const std::string& name) {
    if (name == "peer" && !on_one_host(comm)) return "the ranks are on several hosts";
    if (name == "nccl" && !why_no_nccl().empty()) return why_no_nccl();
    if (name == "nccl" && devices_are_shared(comm)) return "ranks share a device, which NCCL does not allow";
    if (name == "mpi" && !mpi_is_cuda_aware()) return "this MPI does not take device memory";
    return {};
}

std::unique_ptr<WireMaker> maker(const Comm& comm, const std::string& name) {
    if (name == "peer") return peer_wires(comm);
    if (name == "nccl") return nccl_wires(comm);
    return mpi_wires(comm, name == "mpi" ? MpiMemory::device : MpiMemory::pinned);
}

/// The wires, tried; or null, and why not.
std::unique_ptr<WireMaker> tried(const Comm& comm, const std::string& name, std::string& why_not) {
    why_not = obstacle(comm, name);
    if (!why_not.empty()) return nullptr;
    std::unique_ptr<WireMaker> wires = maker(comm, name);
    const std::unique_ptr<Wire> wire = wires->make(90);
    why_not = wire_trial(comm, *wire, 4096, 4);
    return why_not.empty() ? std::move(wires) : nullptr;
}

}  // namespace

std::unique_ptr<WireMaker> choose_wires(const Comm& comm, const std::string& wanted, std::string& words) {
    std::string why_not, passed_over;
    if (wanted != "auto") {
        std::unique_ptr<WireMaker> wires = tried(comm, wanted, why_not);
        if (!wires)
            throw InputError("--transport " + wanted + " cannot be had (" + why_not + "). Use --transport auto?");
        words = "messages by " + wanted + " (--transport)";
        return wires;
    }
    for (const char* name : {"peer", "nccl", "mpi"}) {
        if (std::unique_ptr<WireMaker> wires = tried(comm, name, why_not)) {
            words = std::string("messages by ") + name + " (tried and right" + passed_over + ")";
            return wires;
        }
        passed_over += std::string("; not ") + name + ": " + why_not;
    }
    words = "messages by host (" + passed_over.substr(2) + ")";
    return mpi_wires(comm, MpiMemory::pinned);
}

}  // namespace moraine::gpu
