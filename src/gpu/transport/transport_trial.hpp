#pragma once
// Whether a transport carries: some rounds of messages of known content between all ranks, checked where they arrive.

#include <functional>

#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

/// Whether two ranks are each other's peers; the same for both.
using ArePeers = std::function<bool(int, int)>;

/// What is wrong with a transport that is opened with messages of up to `bytes`, for all pairs of ranks or those of
/// `are_peers`; empty: nothing, the same on all ranks. Collective.
std::string transport_trial(const Comm& comm, Transport& transport, std::size_t bytes, int rounds,
                            const ArePeers& are_peers = {});

/// What `entry` makes, tried between all ranks; or null, and why not. Collective.
std::unique_ptr<TransportFactory> tried_transport(const Comm& comm, const TransportEntry& entry, std::string& why_not);

}  // namespace moraine::gpu
