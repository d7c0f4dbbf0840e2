#pragma once
// Which ranks share a host: messages between them cost less than messages over the network.
//
// Plain data, the same on all ranks, so that a replay can have hosts that nobody started. Hosts are numbered from 0 in
// the order of their lowest ranks. For tests the environment variable MORAINE_PRETEND_HOSTS = N divides the ranks into
// N hosts of ranks in a row, and MORAINE_PRETEND_HOSTS = 0,1,0,1 says the host of each rank: what crosses is sent as
// between hosts, devices and memory are shared as they are.

#include <cstdint>
#include <span>
#include <vector>

#include "comm/comm.hpp"

namespace moraine {

using HostOfRank = std::vector<std::int32_t>;

/// Hosts of `ranks_per_host` ranks in a row, the last of what is left; none per host: one host. Not collective.
HostOfRank hosts_of(int ranks, int ranks_per_host);

/// Not collective.
std::int32_t host_count(std::span<const std::int32_t> host_of_rank);

/// Ranks by host, ascending within one: where parts in a row stay on a host as long as they can. Not collective.
std::vector<std::int32_t> ranks_by_host(std::span<const std::int32_t> host_of_rank);

/// Of this run. Throws InputError, the same on all ranks, for a MORAINE_PRETEND_HOSTS that names no hosts (rank 0's is
/// taken). More hosts than ranks: as many as ranks; of a list longer than the ranks its begin. Collective.
HostOfRank find_hosts(const Comm& comm);

}  // namespace moraine
