#pragma once
// The entries of one block's list that changed cell or block, from one bit each, as a warp's work.
//
// The bits of 1024 entries are one word per lane. Their positions are gathered in shared memory in list order, so that
// the lanes then work on changed entries only; rank() counts those before any entry without looking at them.

#include "gpu/kernels/warp.cuh"

namespace moraine::gpu {

class ChangedEntries {
  public:
    static constexpr std::uint32_t span = 1024;  ///< entries of the list that are gathered at a time

    /// words: of this block. gathered: `span` numbers in shared memory, of this warp.
    __device__ ChangedEntries(const std::uint32_t* words, std::uint32_t count, std::uint16_t* gathered)
        : words_(words), count_(count), gathered_(gathered), bits_(bits_from(0)) {}

    /// Bits of the entries base + 32 lane ...
    __device__ std::uint32_t bits_from(std::uint32_t base) const {
        const std::uint32_t w = base / 32 + static_cast<std::uint32_t>(lane_id());
        return 32 * w < count_ ? words_[w] : 0;
    }

    /// Before the first gather().
    __device__ bool any() const {
        std::uint32_t found = bits_;
        for (std::uint32_t base = span; base < count_; base += span) found |= bits_from(base);
        return __any_sync(all_lanes, found != 0);
    }

    /// Holds the changed ones among entries base ... base + span.
    __device__ void gather(std::uint32_t base) {
        if (base != 0 || held_ < nothing) bits_ = bits_from(base);
        const auto mine = static_cast<std::uint32_t>(__popc(bits_));
        const std::uint32_t upto = scan_inclusive(mine);
        before_ = upto - mine;
        held_count_ = __shfl_sync(all_lanes, upto, 31);
        held_ = base;
        __syncwarp();
        std::uint32_t at = before_;
        for (std::uint32_t rest = bits_; rest != 0; rest &= rest - 1)
            gathered_[at++] = static_cast<std::uint16_t>(32 * lane_id() + __ffs(static_cast<int>(rest)) - 1);
        __syncwarp();
    }

    /// Held ones before list entry e. All lanes call it, each with its own e.
    __device__ std::uint32_t rank(std::uint32_t e) const {
        const std::uint32_t at = e <= held_ ? 0 : min(e - held_, span);
        const int lane = static_cast<int>(at / 32) & 31;
        const std::uint32_t bits = __shfl_sync(all_lanes, bits_, lane);
        const std::uint32_t before = __shfl_sync(all_lanes, before_, lane);
        return at == span ? held_count_ : before + static_cast<std::uint32_t>(__popc(bits & ((1u << (at & 31)) - 1)));
    }

    /// Calls f(list entry, active) for those held, in list order, 32 at a time; all lanes take part.
    template <class F>
    __device__ void each_held(const F& f) const {
        for (std::uint32_t j = 0; j < held_count_; j += 32) {
            const std::uint32_t k = j + static_cast<std::uint32_t>(lane_id());
            const bool active = k < held_count_;
            f(held_ + (active ? gathered_[k] : 0), active);
        }
    }

    /// The same for all of the block's; does not gather again what it holds.
    template <class F>
    __device__ void each(const F& f) {
        for (std::uint32_t base = 0; base < count_; base += span) {
            if (held_ != base) gather(base);
            each_held(f);
        }
    }

  private:
    static constexpr std::uint32_t nothing = 0xffffffffu;

    const std::uint32_t* words_;
    std::uint32_t count_;
    std::uint16_t* gathered_;
    std::uint32_t bits_;            ///< of the span that is held; at first of the first one
    std::uint32_t held_ = nothing;  ///< first entry of the span that is held
    std::uint32_t held_count_ = 0;
    std::uint32_t before_ = 0;  ///< held ones in the words of the lanes below
};

}  // namespace moraine::gpu
