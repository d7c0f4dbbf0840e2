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
#include "app/stop_signals.hpp"
#include "app/watchdog.hpp"
#include "io/csv_log.hpp"
#include "io/vtkhdf.hpp"
#include "records/hazard_maps.hpp"
#include "records/load_record.hpp"
#include "records/run_health.hpp"
#include "records/section_flow.hpp"
#include "records/structure_path.hpp"
#include "records/time_series.hpp"
#include "simulation/rest_watch.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

template <class Real, int Dim>
class Driver {
  public:
    /// Collective.
    Driver(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device);

    /// Collective. Throws what the simulation throws, after the last state was written.
    void run();

  private:
    void begin();
    RunClaim claim() const;
    void open_records(std::optional<ResumeAfter> resume, const std::vector<double>& path_rows);
    void find_written();
    void advance();
    bool ends_at_rest() const;
    void watch_rest();
    void begin_stage();
    double next_look() const;
    void after_step();
    void output();
    void warn(const TimeSeriesRow<Dim>& row);
    void record_balance();
    void record_structures();
    void sample_maps();
    void checkpoint();
    void finish(const std::string& ended_by);
    double wall() const;
    bool stop_asked() const;

    const Scene& scene_;
    const Options& options_;
    const Comm& comm_;
    std::string directory_, device_message_;
    RunLock lock_;  ///< of the directory; rank 0's
    Simulation<Real, Dim> sim_;
    std::unique_ptr<CsvLog> history_, balance_, structures_, gauges_, sections_;  ///< the last three: if there are any
    std::unique_ptr<LoadRecord<Real, Dim>> loads_;                                ///< none unless the scene asks for it
    std::unique_ptr<HazardMaps> maps_;        ///< none unless the scene asks for them
    std::unique_ptr<SectionFlow> flow_;       ///< none unless the scene has sections
    std::unique_ptr<RestWatch<Dim>> rest_;    ///< none unless the run or its stage is to end at rest
    std::unique_ptr<ParticleSeries> series_;  ///< none: --no-particles
    std::unique_ptr<StructurePath> path_;     ///< none: no series, or no structure moves
    std::unique_ptr<Progress> progress_;
    RunHealth<Dim> health_;
    std::unique_ptr<Watchdog> watchdog_;
    double start_wall_ = 0;  ///< [s]
    double stepping_ = 0;    ///< wall time of the steps alone [s]
    double last_checkpoint_wall_ = 0;
    std::int64_t next_output_ = 1;      ///< in output intervals
    std::int64_t next_structures_ = 1;  ///< in intervals of structures.csv
    std::int64_t next_checkpoint_ = 1;  ///< in checkpoint intervals
    bool said_memory_ = false;          ///< that no owners fit the memory of all ranks
    std::int64_t last_output_step_ = -1, last_checkpoint_step_ = -1, last_sample_step_ = -1;
    RunCounts reported_;  ///< as of the last row of balance.csv
    std::array<double, Phases::count> reported_seconds_{};
    std::string changes_;  ///< what restarts changed (records/scene_change_record.hpp)
};

/// Reads nothing, runs all: the instance for the scene's precision and dimension, on the host or on this rank's
/// device. Collective.
void run_scene(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device);

}  // namespace moraine
