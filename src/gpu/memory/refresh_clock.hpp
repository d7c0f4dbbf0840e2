#pragma once
// When memory is next put into list order (gpu/memory/refresh.hpp). Rows in an old order cost time where they come from
// the device's memory. Where all of them stay in its L2 cache they hardly do, and a refresh is what costs: its
// launches, and the end of a lead (gpu/lead.hpp).
//
// No answer depends on it: all sums go by lists.

#include <cstddef>

namespace moraine::gpu {

class RefreshClock {
  public:
    static constexpr int usual = 12;  ///< steps; 8 to 16 are equally good (benchmarks/device/results.md)
    static constexpr int rare = 48;   ///< where the particles stay in the cache (docs/adr/0013-device-leads.md)

    /// always: so many steps, whatever fit() is told; 0: by that.
    explicit RefreshClock(int always) : always_(always), interval_(always > 0 ? always : usual) {}

    /// Of particles that take so much memory, on a device with such a cache [bytes].
    void fit(std::size_t particles, std::size_t cache) {
        if (always_ == 0) interval_ = particles <= cache ? rare : usual;
    }
    void step() { ++since_; }
    void begin_again() { since_ = 0; }

    /// Steps until the next one.
    int left() const { return interval_ - since_; }

  private:
    int always_, interval_;
    int since_ = 0;  ///< steps since the last one
};

}  // namespace moraine::gpu
