#pragma once
// Places of messages by peer, as one piece of memory is cut up for them, and the pointers to them on the device.

#include <vector>

#include "gpu/memory/array.hpp"
#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

constexpr std::size_t message_align = 256;

inline std::size_t message_capacity(std::size_t bytes) {
    return (std::max(bytes, sizeof(MessageHead)) + message_align - 1) / message_align * message_align;
}

/// Starts of the peers' capacities (&TransportPeer::capacity_out or capacity_in) one after the other, and their sum.
inline std::vector<std::size_t> capacity_starts(const std::vector<TransportPeer>& peers,
                                                std::size_t TransportPeer::*capacity) {
    std::vector<std::size_t> start{0};
    for (const TransportPeer& peer : peers) start.push_back(start.back() + message_capacity(peer.*capacity));
    return start;
}

/// An array of pointers on the device.
class PointerArray {
  public:
    void assign(const std::vector<std::byte*>& pointers) { pointers_.assign(pointers); }
    std::byte* const* out() const { return pointers_.data(); }
    const std::byte* const* in() const { return const_cast<const std::byte* const*>(pointers_.data()); }

  private:
    Array<std::byte*> pointers_;
};

}  // namespace moraine::gpu
