#pragma once
// A transport between devices of one host: kernels write into the inbox of the peer's device, over NVLink where there
// is any (CUDA IPC). The host takes no part in a round: a flag in the receiver's memory, raised behind the message,
// lets the receiver's stream go on.
//
// Inboxes are double: a rank writes round n + 2 only after it has seen round n + 1 of a peer, and the peer sent that
// after it had read round n.

#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

/// A transport whose pointers are two sets in turn.
class TwoSetTransport : public Transport {
  public:
    /// 0 or 1: which of them outgoing() and incoming() are now.
    virtual std::size_t outgoing_set() const = 0;
    virtual std::size_t incoming_set() const = 0;
    /// By peer, from one opening to the next.
    virtual std::vector<std::byte*> outgoing_pointers(int set) const = 0;
    virtual std::vector<std::byte*> incoming_pointers(int set) const = 0;
};

/// Between the ranks of `comm`, which must be on one host and outlive it. Not collective.
std::unique_ptr<TwoSetTransport> peer_transport(const Comm& comm);

/// All ranks must be on one host. See TransportEntry. Collective.
std::string peer_obstacle(const Comm& comm);
std::unique_ptr<TransportFactory> peer_transports(const Comm& comm);

}  // namespace moraine::gpu
