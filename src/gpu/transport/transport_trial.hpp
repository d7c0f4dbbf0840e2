#pragma once
// Whether a wire carries: some rounds of messages of known content between all ranks, checked where they arrive.

#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

/// What is wrong with a wire that is opened for all ranks with messages of up to `bytes`; empty: nothing, the same on
/// all ranks. Collective.
std::string wire_trial(const Comm& comm, Wire& wire, std::size_t bytes, int rounds);

}  // namespace moraine::gpu
