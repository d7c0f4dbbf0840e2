#pragma once
// Whether a transport carries: some rounds of messages of known content between all ranks, checked where they arrive.

#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

/// What is wrong with a transport that is opened for all ranks with messages of up to `bytes`; empty: nothing, the same
/// on all ranks. Collective.
std::string transport_trial(const Comm& comm, Transport& transport, std::size_t bytes, int rounds);

}  // namespace moraine::gpu
