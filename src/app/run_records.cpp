#include "app/run_records.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "app/run_directory.hpp"
#include "io/disk_file.hpp"
#include "predict/scene_warnings.hpp"
#include "records/checkpoint_state.hpp"
#include "records/frame_choice.hpp"
#include "records/map_tags.hpp"
#include "records/scene_change_record.hpp"
#include "records/scene_record.hpp"
#include "records/structure_record.hpp"
#include "records/summary.hpp"
#include "records/surroundings_file.hpp"
#include "records/time_report.hpp"
#include "seeding/seed_region.hpp"

namespace moraine {

std::int64_t next_multiple(double interval, double t) {
    if (!(interval > 0)) return 1;
    const double most = 9007199254740992;  // 2^53: whole numbers are exact up to here
    double k = std::max(1.0, std::floor(std::min(t / interval, most)));
    while (k < most && k * interval <= t) ++k;
    return static_cast<std::int64_t>(k);
}

template <class Real, int Dim>
RunRecords<Real, Dim>::RunRecords(const Scene& scene, const Options& options, Simulation<Real, Dim>& sim,
                                  const std::string& directory, std::function<void(const std::string&)> say)
    : scene_(scene), options_(options), sim_(sim), comm_(sim.comm()), directory_(directory), say_(std::move(say)) {
    if (scene.hazard.cell > 0) maps_ = std::make_unique<HazardMaps>(scene, comm_);
    if (!scene.hazard.sections.empty()) flow_ = std::make_unique<SectionFlow>(scene, comm_);
}

template <class Real, int Dim>
RestartedRecords RunRecords<Real, Dim>::restore(const CheckpointReader& file) {
    load(sim_, comm_, file, options_.restart, options_.allow_changes);
    const SavedRecords records = saved_records(file);
    const auto changes = changes_from(scene_, file.get<std::string>("scene"), options_.allow_changes);
    changes_ = with_changes(records.changes, changes, sim_.clock().step, sim_.clock().time);
    if (!records.health.empty() && !health_.restore(records.health)) file.refuse("no run has its warnings");
    if (maps_ && !maps_->restore(records.maps)) file.refuse("no run has its maps");
    if (flow_ && !flow_->restore(records.sections)) file.refuse("no run has its sections");
    // What rested with other strengths has not yet with these.
    return {records.history_row, records.structure_path, changes.empty() ? records.rest : std::vector<std::int64_t>{}};
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::open(std::optional<ResumeAfter> resume, const std::vector<double>& path_rows) {
    open_series();
    history_ =
        std::make_unique<CsvLog>(comm_, directory_ + "/history.csv", TimeSeriesRow<Dim>::columns(scene_), resume);
    if (resume) resume->row.clear();  // the others tell of times, which differ from run to run
    balance_ =
        std::make_unique<CsvLog>(comm_, directory_ + "/balance.csv", BalanceRow::columns(scene_.sleep.on), resume);
    if (!sim_.structures().empty())
        structures_ = std::make_unique<CsvLog>(comm_, directory_ + "/structures.csv",
                                               structure_columns<Dim>(sim_.structures().any_turns()), resume);
    if (!scene_.hazard.gauges.empty())
        gauges_ = std::make_unique<CsvLog>(comm_, directory_ + "/gauges.csv", maps_->gauge_columns(), resume);
    if (flow_) sections_ = std::make_unique<CsvLog>(comm_, directory_ + "/sections.csv", flow_->columns(), resume);
    if (path_ && !path_->restore(path_rows))
        throw InputError(fmt::format("{} does not hold these structures. Another checkpoint?", options_.restart));
    if (maps_) {
        const std::string notice = maps_->prepare(directory_);
        if (!notice.empty()) say_(fmt::format("Warning: {}", notice));
    }
    if (scene_.output.block_loads)
        loads_ = std::make_unique<LoadRecord<Real, Dim>>(sim_, comm_, directory_ + "/block_loads.bin",
                                                         resume ? std::optional(sim_.clock().step) : std::nullopt);
    // Nobody refuses from here on, so what was there before a refusal is there after it.
    for (CsvLog* table : {history_.get(), balance_.get(), structures_.get(), gauges_.get(), sections_.get()})
        if (table) table->begin();
    write_scene();
    if (series_ && resume) series_->truncate_to(sim_.clock().time);
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::open_series() {
    if (options_.no_particles) return;
    series_ = std::make_unique<ParticleSeries>(comm_, directory_ + "/" + series_name(scene_),
                                               SeriesOptions{scene_.output.deflate, scene_.output.asynchronous});
    if (sim_.structures().any_moves())
        path_ = std::make_unique<StructurePath>(scene_, comm_, directory_ + "/structures.vtkhdf");
    with_frame(sim_, [&](auto& frame) { series_->check_types(frame.position(), frame.fields()); });
}

/// What the run is of: its scene, and for pictures what surrounds it.
template <class Real, int Dim>
void RunRecords<Real, Dim>::write_scene() {
    std::vector<double> volumes;
    for (const BodySpec& body : scene_.bodies)
        volumes.push_back(body.shape == BodyShape::table ? 0 : measure_of(body, scene_.dimensions));
    write_summary(comm_, directory_ + "/scene.json", surroundings(scene_, volumes));
    if (!series_) return;
    comm_.agree_no_error<MachineError>(message_of([&] {
        if (comm_.is_root() && has_surroundings(scene_))
            replace_file(directory_ + "/surroundings.vtkhdf", surroundings_image(scene_));
    }));
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::begin(bool restarts, bool resumes) {
    const double time = sim_.clock().time;
    next_output_ = next_multiple(scene_.output.interval, time);
    next_structures_ = next_multiple(scene_.output.structure_interval, time);
    if (!restarts) sample_maps(), output();
    if (resumes) find_written();
    if (loads_) loads_->write();
}

/// What the files have of the checkpoint's own step is not written again: a run ends with a row and a frame of the step
/// that its last checkpoint may be of.
template <class Real, int Dim>
void RunRecords<Real, Dim>::find_written() {
    const RunClock<Dim>& clock = sim_.clock();
    const auto has_row = [&](const CsvLog* table) {
        const std::string row = table ? table->last_row() : "";
        return comm_.of_root(static_cast<int>(!row.empty() && std::atoll(row.c_str()) == clock.step)) != 0;
    };
    if (has_row(gauges_.get()) || has_row(sections_.get())) last_sample_step_ = clock.step;
    if (!has_row(history_.get())) return;
    last_output_step_ = clock.step;
    if (path_ && !path_->ends_at(clock.time)) path_->append(clock.time, sim_.structures());
    if (!series_) return;
    const std::vector<double> times = series_->times();
    const bool has_frame = comm_.of_root(static_cast<int>(!times.empty() && times.back() == clock.time)) != 0;
    if (!has_frame) with_frame(sim_, [&](auto& frame) { frame.append_to(*series_); });
}

template <class Real, int Dim>
double RunRecords<Real, Dim>::next_look() const {
    if (loads_) return 0;  // it counts steps
    double next = scene_.end;
    const auto look = [&](double interval, std::int64_t multiple) {
        if (interval > 0) next = std::min(next, static_cast<double>(multiple) * interval);
    };
    look(scene_.output.interval, next_output_);
    if (structures_) look(scene_.output.structure_interval, next_structures_);
    return maps_ ? std::min(next, maps_->next_look()) : next;
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::after_step() {
    const double time = sim_.clock().time;
    const double interval = scene_.output.interval;
    if (series_ && series_->under_way() && sim_.agreement().writing == 0)
        sim_.phases().time(Phase::output, "write particles", [&] { series_->advance(); });
    if (interval > 0 && time >= static_cast<double>(next_output_) * interval) {
        sim_.conclude();
        output();
    }
    const double often = scene_.output.structure_interval;
    if (structures_ && often > 0 && time >= static_cast<double>(next_structures_) * often) {
        sim_.conclude();
        record_structures();
    }
    if (maps_ && maps_->is_due(time)) sample_maps();
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::output() {
    sim_.phases().time(Phase::output, {"output", true}, [&] {
        const TimeSeriesRow<Dim> row = observe(sim_, comm_);
        history_->row(row.values());
        warn(row);
        if (structures_ && scene_.output.structure_interval == 0) record_structures();
        if (series_) with_frame(sim_, [&](auto& frame) { frame.append_to(*series_); });
        if (path_) path_->append(sim_.clock().time, sim_.structures());
    });
    last_output_step_ = sim_.clock().step;
    next_output_ = next_multiple(scene_.output.interval, sim_.clock().time);
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::output_last() {
    if (last_output_step_ != sim_.clock().step) output();
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::warn(const TimeSeriesRow<Dim>& row) {
    for (const HealthWarning<Dim>& w :
         health_.observe(row, sim_.clock().start_strain, std::numeric_limits<Real>::epsilon()))
        say_(w.message());
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::record_structures() {
    sim_.phases().time(Phase::output, "structures", [&] { moraine::record_structures(sim_, *structures_); });
    next_structures_ = next_multiple(scene_.output.structure_interval, sim_.clock().time);
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::sample_maps() {
    if constexpr (Dim == 3) {
        if (!maps_) return;
        sim_.bin();
        const RunClock<Dim>& clock = sim_.clock();
        const auto append = [&](CsvLog& table, const std::vector<double>& values) {
            std::vector<double> row{static_cast<double>(clock.step), clock.time};
            row.insert(row.end(), values.begin(), values.end());
            table.row(row);
        };
        sim_.phases().time(Phase::output, "hazard maps", [&] {
            maps_->sample(sim_);
            if (clock.step == last_sample_step_) return;
            if (gauges_) append(*gauges_, maps_->gauge_values());
            if (!flow_) return;
            flow_->sample(sim_);
            append(*sections_, flow_->values());
        });
        last_sample_step_ = clock.step;
    }
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::record_balance() {
    if (loads_) sim_.phases().time(Phase::output, "block loads", [&] { loads_->write(); });
    const BalanceRow row = balance_row(sim_, comm_, reported_, reported_seconds_);
    balance_->row(row.values());
    if (row.reason != "memory" || std::exchange(said_memory_, true)) return;
    say_(fmt::format(
        "Warning: at step {} (t = {:.6g} s) no other owners of blocks fit the memory of all ranks, and the load "
        "stays as it is (reason \"memory\" in balance.csv). Go on from a checkpoint on more hosts, or with "
        "larger cells?",
        sim_.clock().step, sim_.clock().time));
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::checkpoint(const std::vector<std::int64_t>& rest) {
    sim_.phases().time(Phase::output, {"checkpoint", true}, [&] {
        sim_.conclude();
        if (path_) path_->write();
        if (series_) series_->finish();  // a restart does not write the outputs before its checkpoint again
        save(sim_, comm_, directory_ + "/" + checkpoint_name(sim_.clock().step),
             {history_->last_row(), health_.stored(), maps_ ? maps_->stored() : std::vector<double>{}, rest,
              flow_ ? flow_->stored() : std::vector<std::int64_t>{}, path_ ? path_->stored() : std::vector<double>{},
              changes_});
        if (maps_) maps_->write(directory_, map_tags(sim_, scene_warnings(scene_)));
    });
}

template <class Real, int Dim>
void RunRecords<Real, Dim>::finish() {
    if (path_) path_->write();
    if (series_) sim_.phases().time(Phase::output, {"write particles", true}, [&] { series_->finish(); });
    if (maps_) maps_->write(directory_, map_tags(sim_, scene_warnings(scene_)));
}

template <class Real, int Dim>
std::string RunRecords<Real, Dim>::summarize(const std::string& ended_by, double wall, double stepping) {
    const TimeReport times = time_report(sim_, comm_, wall);
    write_summary(
        comm_, directory_ + "/summary.json",
        moraine::summarize(sim_, comm_, times, stepping, health_, scene_warnings(scene_), ended_by, changes_));
    return times.text();
}

template class RunRecords<float, 2>;
template class RunRecords<float, 3>;
template class RunRecords<double, 2>;
template class RunRecords<double, 3>;

}  // namespace moraine
