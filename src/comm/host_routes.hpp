#pragma once
// Which way messages between two ranks go where there are several hosts: between ranks of one host by a communicator of
// their own, all others by that of the run. Both sides find the same from the hosts of the ranks alone.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "comm/comm.hpp"

namespace moraine {

/// Of each rank its number among the ranks of the host of `rank`, ascending; -1: it is on another host. Not collective.
std::vector<std::int32_t> numbers_on_host(std::span<const std::int32_t> host_of_rank, int rank);

/// The ranks of this rank's host by these numbers. Collective.
std::unique_ptr<const Comm> ranks_of_host(const Comm& comm, std::span<const std::int32_t> host_of_rank);

}  // namespace moraine
