#pragma once
// Transport: move bytes between ranks. It does not know what the bytes mean.
//
// Packing and unpacking belong to the callers (halo, migration, block moves): one halo and one
// migration, whatever the wire. A message may be shorter than the capacity that both sides know;
// capacities above 1 GiB travel in several pieces, because MPI counts are int.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "comm/comm.hpp"

namespace moraine {

/// Bytes that go to, or come from, one other rank.
struct Parcel {
    int peer;
    std::byte* data;
    std::int64_t bytes;     ///< to send; set by finish() for a receive
    std::int64_t capacity;  ///< known to both sides, >= bytes
};

class Transport {
  public:
    virtual ~Transport() = default;
    virtual const char* name() const = 0;

    /// Begins an exchange; parcels and buffers must stay put until finish(). One exchange at a time.
    /// Each send meets a receive of the same capacity on its peer. Not collective.
    virtual void start(std::span<Parcel> sends, std::span<Parcel> receives) = 0;

    /// Waits until every parcel has left and arrived. Not collective.
    virtual void finish() = 0;
};

/// Plain MPI from and to host memory.
class HostTransport final : public Transport {
  public:
    /// `tag` keeps the messages of two transports on one communicator apart. Not collective.
    HostTransport(const Comm& comm, int tag) : comm_(comm), tag_(tag) {}
    const char* name() const override { return "host"; }
    void start(std::span<Parcel> sends, std::span<Parcel> receives) override;
    void finish() override;

  private:
    const Comm& comm_;
    int tag_;
    std::span<Parcel> receives_;
    std::vector<MPI_Request> requests_;
    std::vector<int> owner_;  ///< request -> receive it belongs to; -1 for a send
};

/// Sends each rank r the bytes of to[r] and returns what came, by rank. Sizes travel first. Collective.
std::vector<std::vector<std::byte>> exchange_all(const Comm& comm, const std::vector<std::vector<std::byte>>& to);

}  // namespace moraine
