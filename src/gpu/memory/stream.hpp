#pragma once
// Order on a device: a stream, events, and memory that both sides see.

#include <cuda_runtime.h>

#include "gpu/memory/array.hpp"

namespace moraine::gpu {

class Stream {
  public:
    /// ahead: its kernels are taken first where both have some; apart: copies of another thread, what is captured, or
    /// what comes after the usual: others need not wait for it, nor it for them.
    enum class Rank { usual, ahead, apart, apart_usual, apart_ahead };
    explicit Stream(Rank rank = Rank::usual) {
        int lowest = 0, highest = 0;
        check(cudaDeviceGetStreamPriorityRange(&lowest, &highest), "Making a stream");
        const bool waits = rank == Rank::usual || rank == Rank::ahead;
        const bool ahead = rank == Rank::ahead || rank == Rank::apart_ahead;
        const int usual = highest < lowest ? lowest - 1 : lowest;  // a lower number comes first
        const int priority = ahead ? highest : (rank == Rank::apart ? lowest : usual);
        check(cudaStreamCreateWithPriority(&stream_, waits ? cudaStreamDefault : cudaStreamNonBlocking, priority),
              "Making a stream");
    }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    ~Stream() { cudaStreamDestroy(stream_); }
    operator cudaStream_t() const { return stream_; }
    void wait() const { check(cudaStreamSynchronize(stream_), "A step on the device"); }
    /// Later work waits for the event.
    void wait_for(cudaEvent_t event) const { check(cudaStreamWaitEvent(stream_, event), "Ordering streams"); }

  private:
    cudaStream_t stream_ = nullptr;
};

class Event {
  public:
    explicit Event(unsigned flags = cudaEventDisableTiming) {
        check(cudaEventCreateWithFlags(&event_, flags), "Making an event");
    }
    Event(const Event&) = delete;
    Event& operator=(const Event&) = delete;
    ~Event() { cudaEventDestroy(event_); }
    operator cudaEvent_t() const { return event_; }
    void record(cudaStream_t stream) { check(cudaEventRecord(event_, stream), "Recording an event"); }
    void wait() const { check(cudaEventSynchronize(event_), "A step on the device"); }
    bool is_over() const {
        const cudaError_t now = cudaEventQuery(event_);
        if (now != cudaErrorNotReady) check(now, "A step on the device");
        return now == cudaSuccess;
    }

  private:
    cudaEvent_t event_ = nullptr;
};

/// One T in pinned memory of the host that the device may write.
template <class T>
class Pinned {
  public:
    Pinned() { check(cudaHostAlloc(&data_, sizeof(T), cudaHostAllocMapped), "Allocating pinned memory"); }
    Pinned(const Pinned&) = delete;
    Pinned& operator=(const Pinned&) = delete;
    ~Pinned() { cudaFreeHost(data_); }
    T* device() const {
        T* seen = nullptr;
        check(cudaHostGetDevicePointer(&seen, data_, 0), "Mapping pinned memory");
        return seen;
    }
    T& host() { return *data_; }
    const T& operator*() const { return *data_; }
    const T* operator->() const { return data_; }

  private:
    T* data_ = nullptr;
};

}  // namespace moraine::gpu
