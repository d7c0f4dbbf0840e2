#pragma once
// Device memory that is taken and given back in the order of a stream, from a pool that keeps what it has: for tables
// that change their size from epoch to epoch, in the middle of a run. cudaMalloc() and cudaFree() would wait for the
// whole device, and with it for the others whose messages its kernels wait for.
//
// Not for what peers map (they need cudaMalloc), nor for the particles: a pool holds on to pieces that became too
// small. Invariant: whoever gives a stream to resize() or assign() has all kernels that read the old content behind it
// there, or has waited for them.

#include <cstdint>
#include <map>
#include <mutex>

#include "gpu/memory/array.hpp"

namespace moraine::gpu {

inline cudaMemPool_t make_memory_pool(int device) {
    cudaMemPoolProps props{};
    props.allocType = cudaMemAllocationTypePinned;
    props.location.type = cudaMemLocationTypeDevice;
    props.location.id = device;
    cudaMemPool_t made = nullptr;
    check(cudaMemPoolCreate(&made, &props), "Making a pool of device memory");
    std::uint64_t kept = std::uint64_t(1) << 30;  // [bytes]; of more, what is idle goes back when somebody waits
    check(cudaMemPoolSetAttribute(made, cudaMemPoolAttrReleaseThreshold, &kept), "Making a pool of device memory");
    int no = 0;  // nobody who copies tables waits for the stream of the steps
    check(cudaMemPoolSetAttribute(made, cudaMemPoolReuseAllowInternalDependencies, &no),
          "Making a pool of device memory");
    return made;
}

inline void give_back_idle_pool();

/// Of the current device, for the whole process: one that computed alone may be a rank of several on another device
/// later. Any thread may ask.
inline cudaMemPool_t memory_pool() {
    static std::mutex asked;
    static std::map<int, cudaMemPool_t> pools;
    int device = 0;
    check(cudaGetDevice(&device), "Asking for the device");
    const std::lock_guard lock(asked);
    auto found = pools.find(device);
    if (found == pools.end()) found = pools.emplace(device, make_memory_pool(device)).first;
    give_back_idle_memory = give_back_idle_pool;
    return found->second;
}

inline void give_back_idle_pool() {
    check(cudaDeviceSynchronize(), "A step on the device");
    check(cudaMemPoolTrimTo(memory_pool(), 0), "Giving back device memory");
}

/// As Array (gpu/memory/array.hpp); content is lost when it grows.
template <class T>
class PoolArray {
  public:
    PoolArray() = default;
    PoolArray(const PoolArray&) = delete;
    PoolArray& operator=(const PoolArray&) = delete;
    ~PoolArray() { cudaFree(data_); }

    T* data() const { return data_; }
    std::size_t size() const { return size_; }

    /// Capacity for n elements, and some more where it grows: the next epoch differs a little.
    void resize(std::size_t n, cudaStream_t stream) {
        if (n > capacity_) reserve(n + (capacity_ > 0 ? n / 16 : 0), stream);
        size_ = n;
    }
    void release(cudaStream_t stream) {
        if (data_) check(cudaFreeAsync(data_, stream), "Giving back device memory");
        data_ = nullptr, size_ = capacity_ = 0;
    }
    /// Queued; `from` may change at once, the copy is there when the stream has been waited for.
    void assign(const std::vector<T>& from, cudaStream_t stream) {
        if (from.size() > capacity_) reserve(from.size() + from.size() / 8, stream);
        size_ = from.size();
        if (size_ > 0)
            check(cudaMemcpyAsync(data_, from.data(), size_ * sizeof(T), cudaMemcpyHostToDevice, stream),
                  "Copying to the device");
    }
    /// As it is by what stream has queued so far; waits for it. Not on the stream of the steps (Array::host()).
    std::vector<T> host(cudaStream_t stream = nullptr) const {
        std::vector<T> to(size_);
        if (size_ > 0)
            check(cudaMemcpyAsync(to.data(), data_, size_ * sizeof(T), cudaMemcpyDeviceToHost, stream),
                  "Copying from the device");
        check(cudaStreamSynchronize(stream), "Copying from the device");
        return to;
    }

    void swap(PoolArray& other) {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        std::swap(capacity_, other.capacity_);
    }

  private:
    void reserve(std::size_t n, cudaStream_t stream) {
        release(stream);
        data_ = static_cast<T*>(
            take_memory([&](void** to) { return cudaMallocFromPoolAsync(to, n * sizeof(T), memory_pool(), stream); }));
        capacity_ = n;
    }

    T* data_ = nullptr;
    std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace moraine::gpu
