#pragma once
// How bytes get from the device of one rank to that of another. A transport does not know what they mean.
//
// A round is one message each way between this rank and each peer. Kernels write a message at outgoing(k), wherever
// that is (pinned memory, the peer's device), and read one at incoming(k). A message begins with its length, so that
// what does not know lengths ahead (kernels, one rank) can tell what does (MPI, NCCL).
//
// start() .. finish() is a round:  kernels write | start | post | finish | kernels read.  Rounds of one transport are
// queued on one stream, one after the other. With post() a caller queues other work before the host must wait.

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "comm/comm.hpp"

namespace moraine::gpu {

/// First bytes of a message.
struct alignas(16) MessageHead {
    std::uint64_t bytes;  ///< of the message with its head; a multiple of 16
    std::uint64_t count;  ///< the writer's
};

/// Another rank, and the capacity for messages to it and from it [bytes], known to both.
struct TransportPeer {
    int rank;
    std::size_t capacity_out;
    std::size_t capacity_in;
};

class Transport {
  public:
    virtual ~Transport() = default;
    virtual const char* name() const = 0;

    /// New peers and capacities, between two rounds of the host. If a is a peer of b, b is one of a. Collective over
    /// all ranks.
    virtual void open(const std::vector<TransportPeer>& peers) = 0;

    /// For kernels: arrays of pointers, by peer, that hold for the round to come (outgoing) or just finished
    /// (incoming).
    virtual std::byte* const* outgoing() const = 0;
    virtual const std::byte* const* incoming() const = 0;

    /// What kernels queued on the stream wrote goes. Asynchronous. Not collective.
    virtual void start(cudaStream_t stream) = 0;
    /// The host's part of the sending; may wait for the stream. Not collective.
    virtual void post() = 0;
    /// Kernels queued on the stream from now on find all messages. May wait. Not collective.
    virtual void finish(cudaStream_t stream) = 0;
};

/// Transports of one kind for one communicator.
class TransportFactory {
  public:
    virtual ~TransportFactory() = default;
    virtual const char* name() const = 0;
    /// For the user: the name, and what it makes of which pairs.
    virtual std::string description() const { return name(); }
    /// `tag` keeps transports apart. Collective.
    virtual std::unique_ptr<Transport> make(int tag) const = 0;
};

/// One row of the table of transports.
struct TransportEntry {
    std::string_view name;
    /// Why it cannot be had, without trying it; empty: it can be tried. Collective.
    std::string (*obstacle)(const Comm&);
    std::unique_ptr<TransportFactory> (*make)(const Comm&);  ///< collective
};

/// All, by the names of comm/transport_names.hpp and in that order.
std::span<const TransportEntry> transports();

/// `wanted`: one of transport_names, or auto: the first that works between all ranks, which is tried. The message says
/// what and why. Throws InputError, the same on all ranks, where what is wanted cannot be had. The current device is
/// this rank's. Collective.
std::unique_ptr<TransportFactory> choose_transport(const Comm& comm, const std::string& wanted, std::string& message);

}  // namespace moraine::gpu
