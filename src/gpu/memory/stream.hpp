#pragma once
// Order and time on a device: a stream, events, memory that both sides see, and a stopwatch for the parts of a step.

#include <cuda_runtime.h>

#include <array>

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

/// Times of the three parts of a step, without what lies between them, taken one step late so that nobody waits.
class Stopwatch {
  public:
    static constexpr int parts = 3;

    /// Part 0, 1 or 2 of the step begins here. Part 0 begins a step.
    void begin(int part, cudaStream_t stream) {
        if (part == 0) laps_[now_ = 1 - now_].ended = 0;
        laps_[now_].event[2 * part].record(stream);
    }
    /// Part 0 begins here after all.
    void begin_again(cudaStream_t stream) { laps_[now_].event[0].record(stream); }
    /// It ends here; of several calls the last counts.
    void end(int part, cudaStream_t stream) {
        laps_[now_].event[2 * part + 1].record(stream);
        laps_[now_].ended = part + 1;
    }
    /// Seconds of the parts of the last step that ended, once; its work must be done.
    std::array<double, parts> take() {
        std::array<double, parts> seconds{};
        Lap& lap = laps_[laps_[now_].ended == parts ? now_ : 1 - now_];
        for (std::size_t k = 0; k < parts && lap.ended == parts; ++k) {
            float ms = 0;
            check(cudaEventElapsedTime(&ms, lap.event[2 * k], lap.event[2 * k + 1]), "Reading the time of a step");
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
        TimedEvent event[2 * parts];
        int ended = 0;
    };
    Lap laps_[2];
    int now_ = 0;
};

}  // namespace moraine::gpu
