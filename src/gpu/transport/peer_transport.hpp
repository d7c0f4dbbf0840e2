#pragma once
// A transport between devices of one host: kernels write into the inbox of the peer's device, over NVLink where there
// is any (CUDA IPC). The host takes no part in a round: a flag in the receiver's memory, raised behind the message,
// lets the receiver's stream go on.
//
// Inboxes are double: a rank writes round n + 2 only after it has seen round n + 1 of a peer, and the peer sent that
// after it had read round n.

#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

/// All ranks must be on one host. See TransportEntry. Collective.
std::string peer_obstacle(const Comm& comm);
std::unique_ptr<TransportFactory> peer_transports(const Comm& comm);

}  // namespace moraine::gpu
