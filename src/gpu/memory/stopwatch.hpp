#pragma once
// Times of the three parts of a step, without what lies between them, taken one step late so that nobody waits.
//
// Six timed events cost a stream 12 us a step (NVIDIA H100, CUDA 13.0), so one step in `interval` is timed, and those
// up to the next one count as long as it: sums are estimates of the parts' seconds. Where steps are counted alike ranks
// time the same ones, and can be compared. No answer depends on it.

#include <array>

#include "gpu/memory/stream.hpp"

namespace moraine::gpu {

class Stopwatch {
  public:
    static constexpr int parts = 3;
    static constexpr int interval = 4;
    using Seconds = std::array<double, parts>;

    /// From now on every step is timed: where few are the host's.
    void time_all() { times_all_ = true; }

    /// Part 0 of another step begins here.
    void begin_step(cudaStream_t stream) {
        ++untimed_;
        begin_lap(times_all_ || untimed_ >= interval);
        if (lap().timed) untimed_ = 0;
        begin_part(0, stream);
    }
    /// Part 0, 1 or 2 begins here; part 0: of another round of the step, or of the first step of all.
    void begin(int part, cudaStream_t stream) {
        if (part == 0) begin_lap(lap().timed);
        begin_part(part, stream);
    }
    /// Part 0 begins here after all, and the step is timed.
    void begin_again(cudaStream_t stream) {
        lap().timed = true;
        untimed_ = 0;
        lap().event[0].record(stream);
    }
    /// The step under way is not like others: if it was to be timed, the next one is.
    void skip() {
        if (!lap().timed || times_all_) return;
        lap().timed = false;
        untimed_ = interval;
    }
    /// It ends here; of several calls the last counts.
    void end(int part, cudaStream_t stream) {
        if (lap().timed) lap().event[2 * part + 1].record(stream);
        lap().ended = part + 1;
    }
    /// Seconds of the parts of the last step that ended, by the last one that was timed; once. Its work must be done.
    Seconds take() {
        Lap& last = laps_[lap().ended == parts ? now_ : 1 - now_];
        if (last.ended != parts) return {};
        last.ended = 0;
        if (last.timed) read(last);
        return seconds_;
    }

  private:
    struct TimedEvent : Event {
        TimedEvent() : Event(cudaEventDefault) {}
    };
    struct Lap {
        TimedEvent event[2 * parts];
        int ended = 0;
        bool timed = true;
    };

    Lap& lap() { return laps_[now_]; }
    void begin_lap(bool timed) {
        now_ = 1 - now_;
        lap().ended = 0;
        lap().timed = timed;
    }
    void begin_part(int part, cudaStream_t stream) {
        if (lap().timed) lap().event[2 * part].record(stream);
    }
    void read(const Lap& of) {
        for (std::size_t k = 0; k < parts; ++k) {
            float ms = 0;
            check(cudaEventElapsedTime(&ms, of.event[2 * k], of.event[2 * k + 1]), "Reading the time of a step");
            seconds_[k] = 1e-3 * static_cast<double>(ms);
        }
    }

    Lap laps_[2];
    int now_ = 0;
    int untimed_ = 0;  ///< steps since the last one that was timed
    bool times_all_ = false;
    Seconds seconds_{};  ///< of the last one
};

}  // namespace moraine::gpu
