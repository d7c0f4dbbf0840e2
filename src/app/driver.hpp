#pragma once
// A run from start to end: steps, and between them output, checkpoints, records and signals.
//
// Output happens after the first step at or past its time, a run ends at the first step with
// t >= time.end, or at rest (simulation/rest_watch.hpp): nothing here changes dt or the answer.

#include <memory>

#include "app/device.hpp"
#include "app/options.hpp"
#include "app/progress.hpp"
#include "app/run_directory.hpp"
#include "app/run_lock.hpp"
#include "app/run_records.hpp"
#include "app/stop_signals.hpp"
#include "app/watchdog.hpp"
#include "simulation/rest_watch.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

template <class Real, int Dim>
class Driver {
  public:
    /// Collective.
    Driver(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device,
           Watchdog& watchdog);

    /// Collective. Throws what the simulation throws, after the last state was written.
    void run();

  private:
    void begin();
    RunClaim claim() const;
    void advance();
    bool ends_at_rest() const;
    void watch_rest();
    void begin_stage();
    double next_look() const;
    void after_step();
    void check_volume() const;
    void checkpoint();
    void finish(const std::string& ended_by);
    double wall() const;
    void say(const std::string& text);

    const Scene& scene_;
    const Options& options_;
    const Comm& comm_;
    std::string directory_, device_message_;
    RunLock lock_;  ///< of the directory; rank 0's
    Simulation<Real, Dim> sim_;
    RunRecords<Real, Dim> records_;
    std::unique_ptr<RestWatch<Dim>> rest_;  ///< none unless the run or its stage is to end at rest
    std::unique_ptr<Progress> progress_;
    Watchdog& watchdog_;
    const WatchedPhases watched_;
    std::unique_ptr<Timeline> timeline_;  ///< none without --trace
    double start_wall_ = 0;               ///< [s]
    double stepping_ = 0;                 ///< wall time of the steps alone [s]
    double last_checkpoint_wall_ = 0;
    std::int64_t next_checkpoint_ = 1;  ///< in checkpoint intervals
    std::int64_t last_checkpoint_step_ = -1;
};

/// Reads nothing, runs all: the instance for the scene's precision and dimension, on the host or on this rank's
/// device. Collective.
void run_scene(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device,
               Watchdog& watchdog);

}  // namespace moraine
