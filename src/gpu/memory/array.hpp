#pragma once
// Memory on the device, and the one check of what CUDA answers.

#include <cuda_runtime.h>

#include <string>
#include <utility>
#include <vector>

#include "core/data/rank_failure.hpp"

namespace moraine::gpu {

/// Throws RankFailure `what failed (CUDA's message). ...`.
inline void check(cudaError_t e, const char* what) {
    if (e != cudaSuccess)
        throw RankFailure(std::string(what) + " failed (" + cudaGetErrorString(e) + "). Is the device in order?");
}

/// Gives back what is held idle elsewhere (gpu/memory/pool_array.hpp); null: nothing is.
inline void (*give_back_idle_memory)() = nullptr;

/// The memory that `take(&memory)` takes; where there is none left, what is held idle is given back first.
template <class F>
void* take_memory(const F& take) {
    void* taken = nullptr;
    cudaError_t answer = take(&taken);
    if (answer == cudaErrorMemoryAllocation && give_back_idle_memory) {
        cudaGetLastError();
        give_back_idle_memory();
        answer = take(&taken);
    }
    check(answer, "Allocating device memory");
    return taken;
}

/// Contiguous device memory whose content is not initialised. Grows; content is kept only where a member says so.
template <class T>
class Array {
  public:
    Array() = default;
    Array(const Array&) = delete;
    Array& operator=(const Array&) = delete;
    ~Array() { cudaFree(data_); }

    T* data() const { return data_; }
    std::size_t size() const { return size_; }
    std::size_t capacity() const { return capacity_; }

    /// Capacity for n elements; the old content is lost when it grows.
    void resize(std::size_t n) {
        if (n > capacity_) reserve(n + (capacity_ > 0 ? n / 16 : 0));
        size_ = n;
    }
    void reserve(std::size_t n) {
        if (n <= capacity_) return;
        release();
        data_ = static_cast<T*>(take_memory([&](void** to) { return cudaMalloc(to, n * sizeof(T)); }));
        capacity_ = n;
    }
    void release() {
        cudaFree(data_);
        data_ = nullptr;
        size_ = capacity_ = 0;
    }

    /// Synchronous copies.
    void assign(const T* from, std::size_t n) {
        resize(n);
        if (n > 0) check(cudaMemcpy(data_, from, n * sizeof(T), cudaMemcpyHostToDevice), "Copying to the device");
    }
    void assign(const std::vector<T>& from) { assign(from.data(), from.size()); }
    /// Queued on a stream; `from` may change at once, the copy is there when the stream has been waited for. With
    /// capacity for an eighth more: the next tables differ a little, and to free memory waits for the whole device.
    void assign(const std::vector<T>& from, cudaStream_t stream) {
        if (from.size() > capacity_) reserve(from.size() + from.size() / 8);
        size_ = from.size();
        if (size_ > 0)
            check(cudaMemcpyAsync(data_, from.data(), size_ * sizeof(T), cudaMemcpyHostToDevice, stream),
                  "Copying to the device");
    }
    std::vector<T> host() const {
        std::vector<T> to(size_);
        if (size_ > 0)
            check(cudaMemcpy(to.data(), data_, size_ * sizeof(T), cudaMemcpyDeviceToHost), "Copying from the device");
        return to;
    }

    /// As it is by what stream has queued so far. Not on the stream of the steps: after a copy to pageable memory each
    /// launch on a stream takes 1.3 us more (NVIDIA H200, CUDA 13.0: 1.2 us between kernels became 2.5).
    std::vector<T> host(cudaStream_t stream) const {
        std::vector<T> to(size_);
        if (size_ > 0)
            check(cudaMemcpyAsync(to.data(), data_, size_ * sizeof(T), cudaMemcpyDeviceToHost, stream),
                  "Copying from the device");
        check(cudaStreamSynchronize(stream), "Copying from the device");
        return to;
    }

    void swap(Array& other) {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        std::swap(capacity_, other.capacity_);
    }

  private:
    T* data_ = nullptr;
    std::size_t size_ = 0;
    std::size_t capacity_ = 0;
};

}  // namespace moraine::gpu
