#pragma once
// The watchdog: a run that stands still is ended, and every rank says where it waits.
//
// MPI over TCP waits for a lost host without an error, so no rank would ever know. A thread per rank checks now and
// then, from the first message of a run on, whether a step was finished. Reading, seeding, output, checkpoints and
// plans may take long (a slow disk, a serial partitioner), but a link can be lost in them as well: their time counts a
// tenth. Time in which the process itself was stopped (a suspended job) shows as a gap between two checks, and does not
// count. The last checkpoint is whole: it got its name after its bytes.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
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
    static constexpr double standard_limit = 1800;  ///< the default of run.watchdog [s]

    /// From now on, after `limit` [s]; 0: never. Patient at first. Not collective; throws MachineError where there is
    /// no thread for it.
    Watchdog(int rank, double limit);
    ~Watchdog();
    Watchdog(const Watchdog&) = delete;
    Watchdog& operator=(const Watchdog&) = delete;

    /// What the scene says: counts anew.
    void set_limit(double limit);
    /// Whose phases it tells; none: of a run that has not come to them.
    void look_at(const Phases* phases);
    void step_finished(std::int64_t step) { step_.store(step, std::memory_order_relaxed); }
    /// From now on: at the start and at the end more is read and written than in a step, and it counts a tenth.
    void be_patient(bool patient) { patient_.store(patient, std::memory_order_relaxed); }

  private:
    void watch();
    void watch(double limit);
    bool sleep(double seconds, double limit);
    void end_job(double limit, double pause);
    std::optional<Phase> phase();
    std::string place();

    const int rank_;
    std::atomic<std::int64_t> step_{0};
    std::atomic<bool> patient_{true};
    std::mutex mutex_;
    std::condition_variable changed_;
    double limit_;
    const Phases* phases_ = nullptr;
    bool over_ = false;
    std::thread thread_;
};

/// A watchdog looks at these phases as long as this lives.
class WatchedPhases {
  public:
    WatchedPhases(Watchdog& watchdog, const Phases& phases) : watchdog_(watchdog) { watchdog_.look_at(&phases); }
    ~WatchedPhases() { watchdog_.look_at(nullptr); }
    WatchedPhases(const WatchedPhases&) = delete;
    WatchedPhases& operator=(const WatchedPhases&) = delete;

  private:
    Watchdog& watchdog_;
};

}  // namespace moraine
