#pragma once
// A transport over MPI. `host`: through pinned memory of the host, with any MPI: the scheme of Dong and Grabe (2018).
// `mpi`: from device to device, with an MPI that is CUDA-aware.
//
// Lengths are not known to the host before the kernels ran: it waits for them in post(), and messages go by their
// true length. Messages above 1 GiB go in pieces (comm/point_to_point.hpp).

#include "comm/point_to_point.hpp"
#include "gpu/memory/stream.hpp"
#include "gpu/transport/mailboxes.hpp"

namespace moraine::gpu {

/// From device to device. See TransportEntry. Collective.
std::string mpi_obstacle(const Comm& comm);
std::unique_ptr<TransportFactory> mpi_transports(const Comm& comm);

/// Through memory of the host: works everywhere.
std::string host_obstacle(const Comm& comm);
std::unique_ptr<TransportFactory> host_transports(const Comm& comm);

}  // namespace moraine::gpu
