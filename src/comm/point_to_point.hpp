#pragma once
// Bytes between the hosts of ranks. It does not know what they mean; between devices: gpu/transport.
//
// Packing and unpacking belong to the callers (halo, migration, block moves): one halo and one
// migration. A message may be shorter than the capacity that both sides know;
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

/// Messages between this rank and others, by plain MPI from and to host memory: one exchange at a time.
class PointToPoint {
  public:
    /// `tag` keeps the messages of two of these on one communicator apart. Not collective.
    PointToPoint(const Comm& comm, int tag) : comm_(comm), tag_(tag) {}

    /// Begins an exchange; parcels and buffers must stay put until finish().
    /// Each send meets a receive of the same capacity on its peer. Not collective.
    void start(std::span<Parcel> sends, std::span<Parcel> receives);

    /// Waits until every parcel has left and arrived. Not collective.
    void finish();

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
