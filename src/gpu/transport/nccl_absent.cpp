#include "core/data/error.hpp"
#include "gpu/transport/nccl_transport.hpp"

namespace moraine::gpu {

std::string nccl_obstacle(const Comm&) {
    return "this program was built without NCCL";
}

std::unique_ptr<TransportFactory> nccl_transports(const Comm&) {
    throw MachineError("NCCL is not there (this program was built without it). Use --transport auto?");
}

}  // namespace moraine::gpu
