#pragma once
// Order and time on a device: a stream, events, memory that both sides see, and a stopwatch for the parts of a step.

#include <cuda_runtime.h>

#include <array>

#include "gpu/array.hpp"

namespace moraine::gpu {

class Stream {
  public:
    Stream() { check(cudaStreamCreate(&stream_), "Making a stream"); }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    ~Stream() { cudaStreamDestroy(stream_); }
    operator cudaStream_t() const { return stream_; }
    void wait() const { check(cudaStreamSynchronize(stream_), "A step on the device"); }

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
    const T& operator*() const { return *data_; }
    const T* operator->() const { return data_; }

  private:
    T* data_ = nullptr;
};

/// Times of the parts of a step, taken one step late so that nobody waits for them.
class Stopwatch {
  public:
    /// A step begins here.
    void start(cudaStream_t stream) {
        now_ = 1 - now_;
        laps_[now_].ended = 0;
        mark(0, stream);
    }
    /// Part 1, 2 or 3 of the step ends here; of several calls the last counts.
    void mark(int part, cudaStream_t stream) {
        laps_[now_].event[part].record(stream);
        laps_[now_].ended = part;
    }
    /// Seconds of the parts of the last step that ended, once; its work must be done.
    std::array<double, 3> take() {
        std::array<double, 3> seconds{};
        Lap& lap = laps_[laps_[now_].ended == 3 ? now_ : 1 - now_];
        for (std::size_t k = 0; k < 3 && lap.ended == 3; ++k) {
            float ms = 0;
            check(cudaEventElapsedTime(&ms, lap.event[k], lap.event[k + 1]), "Reading the time of a step");
            seconds[k] = 1e-3 * static_cast<double>(ms);
        }
        lap.ended = 0;
        return seconds;
    }

  private:
    struct TimedEvent : Event {
        TimedEvent() : Event(cudaEventDefault) {}
    };
    struct Lap {
        TimedEvent event[4];
        int ended = 0;
    };
    Lap laps_[2];
    int now_ = 0;
};

}  // namespace moraine::gpu
