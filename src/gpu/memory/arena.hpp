#pragma once
// Device memory for what is made once and kept, piece by piece: what is put stays where it is until all is given up.
// What is put is gathered on the host and goes in one copy.

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

class Arena {
  public:
    /// Where n of them will be once flush() has been queued; null: n is 0.
    template <class T>
    T* put(const T* from, std::size_t n, cudaStream_t stream) {
        static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= alignment);
        if (n == 0) return nullptr;
        const std::size_t bytes = n * sizeof(T);
        std::size_t at = (used_ + alignment - 1) / alignment * alignment;
        if (pieces_.empty() || at + bytes > pieces_[current_]->size()) next_piece(bytes, stream), at = 0;
        staged_.resize(at + bytes - begin_);
        std::memcpy(staged_.data() + (at - begin_), from, bytes);
        used_ = at + bytes;
        return reinterpret_cast<T*>(pieces_[current_]->data() + at);
    }
    template <class T>
    T* put(const std::vector<T>& from, cudaStream_t stream) {
        return put(from.data(), from.size(), stream);
    }
    /// Queued.
    void flush(cudaStream_t stream) {
        if (!staged_.empty())
            check(cudaMemcpyAsync(pieces_[current_]->data() + begin_, staged_.data(), staged_.size(),
                                  cudaMemcpyHostToDevice, stream),
                  "Copying to the device");
        begin_ = used_;
        staged_.clear();
    }
    /// All that was put is given up once the stream comes to what is put next; the memory stays.
    void clear() { current_ = begin_ = used_ = 0, staged_.clear(); }

  private:
    static constexpr std::size_t alignment = 16, least = std::size_t(1) << 18, most = std::size_t(1) << 24;

    void next_piece(std::size_t bytes, cudaStream_t stream) {
        flush(stream);
        if (!pieces_.empty() && used_ > 0) ++current_;
        while (current_ < pieces_.size() && pieces_[current_]->size() < bytes) ++current_;
        if (current_ == pieces_.size()) {
            pieces_.push_back(std::make_unique<PoolArray<std::byte>>());
            pieces_.back()->resize(std::max(bytes, std::min(least << std::min<std::size_t>(current_, 6), most)),
                                   stream);
        }
        begin_ = used_ = 0;
    }

    std::vector<std::unique_ptr<PoolArray<std::byte>>> pieces_;
    std::vector<std::byte> staged_;  ///< of the current piece, from `begin_` on
    std::size_t current_ = 0, begin_ = 0, used_ = 0;
};

}  // namespace moraine::gpu
