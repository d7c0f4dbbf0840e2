#pragma once
// A transport of hosts with several devices each: every pair of ranks of one host by `peer`, every other by the first
// of the others that works between all ranks. One round of both is one round of this one.
//
// Which way a message goes follows from comm/host_groups.hpp alone, the same on both sides. Kernels see one list of
// pointers by peer, whatever is behind them: two in turn, as the inboxes of `peer` are.

#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

/// There must be several hosts, and two ranks on some. See TransportEntry. Collective.
std::string mixed_obstacle(const Comm& comm);
std::unique_ptr<TransportFactory> mixed_transports(const Comm& comm);

}  // namespace moraine::gpu
