#pragma once
// What a run writes while it steps: rows, frames, maps, and what a checkpoint keeps of them. Each when it is due, in
// multiples of its interval; nothing here changes dt or the answer.

#include <functional>
#include <memory>

#include "app/options.hpp"
#include "io/checkpoint.hpp"
#include "io/csv_log.hpp"
#include "io/vtkhdf.hpp"
#include "records/hazard_maps.hpp"
#include "records/load_record.hpp"
#include "records/run_health.hpp"
#include "records/section_flow.hpp"
#include "records/structure_path.hpp"
#include "records/time_series.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

/// What a restarted run goes on from.
struct RestartedRecords {
    std::string history_row;
    std::vector<double> path_rows;
    std::vector<std::int64_t> rest;  ///< RestWatch::stored(); empty: none, or the scene was changed
};

/// The first multiple of the interval that is still to come at time t; of intervals far below a step, none is passed.
std::int64_t next_multiple(double interval, double t);

template <class Real, int Dim>
class RunRecords {
  public:
    /// say(text) tells the user on rank 0. All must outlive it. Collective, as all below but what is const.
    RunRecords(const Scene& scene, const Options& options, Simulation<Real, Dim>& sim, const std::string& directory,
               std::function<void(const std::string&)> say);

    /// Brings the simulation and the records to what the checkpoint holds.
    RestartedRecords restore(const CheckpointReader& file);
    /// Opens the files of a run that begins, or goes on in its directory.
    void open(std::optional<ResumeAfter> resume, const std::vector<double>& path_rows);
    /// Writes what a run begins with; resumes: it goes on in the files of the run before.
    void begin(bool restarts, bool resumes);

    /// The time from which after_step() wants the particles [s].
    double next_look() const;
    bool is_writing() const { return series_ && series_->busy(); }
    /// Writes what is due.
    void after_step();
    void record_balance();
    /// A row and a frame of this step, where it has none.
    void output_last();
    /// With a sample for maps, after conclude().
    void end_part() { sample_maps(), output_last(); }
    /// rest: RestWatch::stored().
    void checkpoint(const std::vector<std::int64_t>& rest);
    /// Closes the files.
    void finish();
    /// Writes the summary; wall: of the run, stepping: of its steps [s]. Returns what took how long, for the user.
    std::string summarize(const std::string& ended_by, double wall, double stepping);

    /// Empty, or why the run ends with a fault.
    const std::string& lost_volume() const { return health_.lost_volume(); }
    bool has_maps() const { return maps_ != nullptr; }

  private:
    void open_series();
    void write_scene();
    void find_written();
    void output();
    void warn(const TimeSeriesRow<Dim>& row);
    void record_structures();
    void sample_maps();

    const Scene& scene_;
    const Options& options_;
    Simulation<Real, Dim>& sim_;
    const Comm& comm_;
    const std::string& directory_;
    const std::function<void(const std::string&)> say_;
    std::unique_ptr<CsvLog> history_, balance_, structures_, gauges_, sections_;  ///< the last three: if there are any
    std::unique_ptr<LoadRecord<Real, Dim>> loads_;                                ///< none unless the scene asks for it
    std::unique_ptr<HazardMaps> maps_;        ///< none unless the scene asks for them
    std::unique_ptr<SectionFlow> flow_;       ///< none unless the scene has sections
    std::unique_ptr<ParticleSeries> series_;  ///< none: --no-particles
    std::unique_ptr<StructurePath> path_;     ///< none: no series, or no structure moves
    RunHealth<Dim> health_;
    std::int64_t next_output_ = 1;      ///< in output intervals
    std::int64_t next_structures_ = 1;  ///< in intervals of structures.csv
    std::int64_t last_output_step_ = -1, last_sample_step_ = -1;
    bool said_memory_ = false;  ///< that no owners fit the memory of all ranks
    RunCounts reported_;        ///< as of the last row of balance.csv
    std::array<double, Phases::count> reported_seconds_{};
    std::string changes_;  ///< what restarts changed (records/scene_change_record.hpp)
};

}  // namespace moraine
