#pragma once
// The watchdog: a run that stands still is ended, and every rank says where it waits.
//
// MPI over TCP waits for a lost host without an error, so no rank would ever know. A thread per rank checks now and
// then whether a step was finished. Seeding, output, checkpoints and plans may take long (a slow disk, a serial
// partitioner), but a link can be lost in them as well: their time counts a tenth. Time in which the process itself was
// stopped (a suspended job) shows as a gap between two checks, and does not count. The last checkpoint is whole: it got
// its name after its bytes.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

#include "comm/phases.hpp"

namespace moraine {

/// Adds up the time since the last finished step. Knows no clock.
class StallTimer {
  public:
    /// Of a gap between two checks, at most `longest_gap` counts. All in [s].
    StallTimer(double limit, double longest_gap, double now);

    /// Once no step was finished for the limit. `share`: of the time since the last check that counts.
    bool expired(double now, std::int64_t step, double share);

  private:
    double limit_, longest_gap_, before_;
    double waited_ = 0;
    std::int64_t step_ = -1;
};

class Watchdog {
  public:
    /// From now on, after `limit` [s]; 0: never. Patient at first. `phases` must outlive it. Not collective; throws
    /// MachineError where there is no thread for it.
    Watchdog(double limit, int rank, const Phases& phases);
    ~Watchdog();
    Watchdog(const Watchdog&) = delete;
    Watchdog& operator=(const Watchdog&) = delete;

    void step_finished(std::int64_t step) { step_.store(step, std::memory_order_relaxed); }
    /// From now on: at the start and at the end more is read and written than in a step, and it counts a tenth.
    void be_patient(bool patient) { patient_.store(patient, std::memory_order_relaxed); }

  private:
    void watch();
    bool sleep(double seconds);
    void end_job(double pause);

    const double limit_;
    const int rank_;
    const Phases& phases_;
    std::atomic<std::int64_t> step_{0};
    std::atomic<bool> patient_{true};
    std::mutex mutex_;
    std::condition_variable changed_;
    bool over_ = false;
    std::thread thread_;
};

}  // namespace moraine
