#pragma once
// Memory of the host that the device may read and write in place, by the byte.

#include "gpu/memory/array.hpp"

namespace moraine::gpu {

class PinnedBytes {
  public:
    PinnedBytes() = default;
    PinnedBytes(const PinnedBytes&) = delete;
    PinnedBytes& operator=(const PinnedBytes&) = delete;
    ~PinnedBytes() { cudaFreeHost(data_); }

    /// The content is lost when it grows.
    void resize(std::size_t n) {
        if (n <= size_) return;
        cudaFreeHost(data_);
        data_ = nullptr, size_ = 0;
        check(cudaHostAlloc(reinterpret_cast<void**>(&data_), n + n / 8, cudaHostAllocMapped),
              "Allocating pinned memory");
        size_ = n + n / 8;
    }
    std::byte* data() const { return data_; }
    std::byte* device() const {
        if (!data_) return nullptr;
        void* seen = nullptr;
        check(cudaHostGetDevicePointer(&seen, data_, 0), "Mapping pinned memory");
        return static_cast<std::byte*>(seen);
    }

  private:
    std::byte* data_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace moraine::gpu
