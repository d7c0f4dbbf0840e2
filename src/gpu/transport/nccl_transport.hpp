#pragma once
// A transport over NCCL: NVLink or network, whatever it finds. One rank per device. A program built without NCCL has
// none.
//
// Lengths travel by MPI once the kernels ran, so that messages go by their true length.

#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

/// See TransportEntry. Collective.
std::string nccl_obstacle(const Comm& comm);

std::unique_ptr<TransportFactory> nccl_transports(const Comm& comm);

}  // namespace moraine::gpu
