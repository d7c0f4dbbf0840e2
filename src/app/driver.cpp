#include "app/driver.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <utility>

#include "app/disk_space.hpp"
#include "io/disk_file.hpp"
#include "predict/capacity.hpp"
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

namespace {

double wall_clock() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Whether a checkpoint, or what a link to it leads to, lies in this directory.
bool is_inside(const std::string& checkpoint, const std::string& directory) {
    if (checkpoint.empty()) return false;
    std::error_code none;
    const auto lies_in = [&](const std::filesystem::path& path) {
        const auto folder = path.parent_path();
        return std::filesystem::equivalent(folder.empty() ? "." : folder, directory, none);
    };
    return lies_in(checkpoint) || lies_in(std::filesystem::weakly_canonical(checkpoint, none));
}

/// The first multiple of the interval that is still to come at time t; of intervals far below a step, none is passed.
std::int64_t next_multiple(double interval, double t) {
    if (!(interval > 0)) return 1;
    const double most = 9007199254740992;  // 2^53: whole numbers are exact up to here
    double k = std::max(1.0, std::floor(std::min(t / interval, most)));
    while (k < most && k * interval <= t) ++k;
    return static_cast<std::int64_t>(k);
}

}  // namespace

template <class Real, int Dim>
Driver<Real, Dim>::Driver(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device)
    : scene_(scene),
      options_(options),
      comm_(comm),
      directory_(options.output.empty() ? default_run_directory(scene.name) : options.output),
      device_message_(device.message),
      sim_(scene, comm, device.cuda ? device_engine_maker<Real, Dim>(scene, comm, device) : nullptr) {
    // Moves within one host leave its memory as full as it was.
    if (!device.cuda && host_count(sim_.hosts()) > 1)
        sim_.hold_at_most(particles_in_memory(scene, {comm.size(), comm.on_this_machine().size, host_memory()}));
    if (scene.hazard.cell > 0) maps_ = std::make_unique<HazardMaps>(scene, comm);
    if (!scene.hazard.sections.empty()) flow_ = std::make_unique<SectionFlow>(scene, comm);
    watch_rest();
}

template <class Real, int Dim>
double Driver<Real, Dim>::wall() const {
    return wall_clock() - start_wall_;
}

/// Collective.
template <class Real, int Dim>
RunClaim Driver<Real, Dim>::claim() const {
    const bool inside = comm_.max(std::int64_t(comm_.is_root() && is_inside(options_.restart, directory_))) != 0;
    if (inside && options_.overwrite)
        throw InputError(
            fmt::format("--overwrite would remove {} (the run is to go on from it). Leave --overwrite "
                        "out to go on in {}, or another --output?",
                        options_.restart, directory_));
    if (options_.overwrite) return RunClaim::overwrite;
    return inside ? RunClaim::resume : RunClaim::fresh;
}

template <class Real, int Dim>
void Driver<Real, Dim>::begin() {
    start_wall_ = wall_clock();
    const bool restarting = !options_.restart.empty();
    const RunClaim claim = this->claim();
    check_run_directory(comm_, directory_, claim);
    std::string history_row;
    std::vector<double> path_rows;
    if (restarting) {
        const CheckpointReader file(comm_, options_.restart);
        load(sim_, comm_, file, options_.restart, options_.allow_changes);
        watch_rest();
        const SavedRecords records = saved_records(file);
        const auto changes = changes_from(scene_, file.get<std::string>("scene"), options_.allow_changes);
        changes_ = with_changes(records.changes, changes, sim_.clock().step, sim_.clock().time);
        history_row = records.history_row;
        if (claim == RunClaim::resume) path_rows = records.structure_path;
        if (!records.health.empty() && !health_.restore(records.health)) file.refuse("no run has its warnings");
        if (maps_ && !maps_->restore(records.maps)) file.refuse("no run has its maps");
        if (flow_ && !flow_->restore(records.sections)) file.refuse("no run has its sections");
        // What rested with other strengths has not yet with these.
        if (rest_ && changes.empty() && !records.rest.empty() && !rest_->restore(records.rest))
            file.refuse("no run rests so");
    } else {
        sim_.seed();
    }
    if (comm_.is_root() && !options_.quiet && !sim_.trigger().notice().empty())
        fmt::print(stderr, "{}\n", sim_.trigger().notice());
    lock_ = claim_run_directory(comm_, directory_, claim);
    catch_stop_signals();
    if (comm_.is_root() && !options_.quiet) {
        std::vector<std::string> warnings = scene_warnings(scene_);
        if (!options_.no_particles)
            warnings.push_back(disk_warning(scene_, sim_.clock().time, free_disk_bytes(directory_)));
        for (const std::string& warning : warnings)
            if (!warning.empty()) fmt::print(stderr, "Warning: {}\n", warning);
        fmt::print(stderr, "{}\n", device_message_);
    }
    const RunClock<Dim>& clock = sim_.clock();
    std::optional<ResumeAfter> resume;
    if (claim == RunClaim::resume) resume = ResumeAfter{"step", static_cast<double>(clock.step), history_row};
    open_records(resume, path_rows);
    next_output_ = next_multiple(scene_.output.interval, clock.time);
    next_structures_ = next_multiple(scene_.output.structure_interval, clock.time);
    next_checkpoint_ = next_multiple(scene_.output.checkpoint_interval, clock.time);
    progress_ = std::make_unique<Progress>(Progress::style_for(options_.quiet, comm_.is_root()), clock.time, scene_.end,
                                           wall());
    if (!restarting) sample_maps(), output();
    if (resume) find_written();
    if (loads_) loads_->write();
}

/// What the files have of the checkpoint's own step is not written again: a run ends with a row and a frame of the step
/// that its last checkpoint may be of.
template <class Real, int Dim>
void Driver<Real, Dim>::find_written() {
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
void Driver<Real, Dim>::open_records(std::optional<ResumeAfter> resume, const std::vector<double>& path_rows) {
    if (!options_.no_particles) {
        series_ = std::make_unique<ParticleSeries>(comm_, directory_ + "/" + series_name(scene_),
                                                   SeriesOptions{scene_.output.deflate, scene_.output.asynchronous});
        if (sim_.structures().any_moves())
            path_ = std::make_unique<StructurePath>(scene_, comm_, directory_ + "/structures.vtkhdf");
        with_frame(sim_, [&](auto& frame) { series_->check_types(frame.position(), frame.fields()); });
    }
    history_ =
        std::make_unique<CsvLog>(comm_, directory_ + "/history.csv", TimeSeriesRow<Dim>::columns(scene_), resume);
    if (resume) resume->row.clear();  // the others tell of times, which differ from run to run
    balance_ =
        std::make_unique<CsvLog>(comm_, directory_ + "/balance.csv", BalanceRow::columns(scene_.sleep.on), resume);
    if (!sim_.structures().empty())
        structures_ = std::make_unique<CsvLog>(comm_, directory_ + "/structures.csv", structure_columns<Dim>(), resume);
    if (!scene_.hazard.gauges.empty())
        gauges_ = std::make_unique<CsvLog>(comm_, directory_ + "/gauges.csv", maps_->gauge_columns(), resume);
    if (flow_) sections_ = std::make_unique<CsvLog>(comm_, directory_ + "/sections.csv", flow_->columns(), resume);
    if (path_ && !path_->restore(path_rows))
        throw InputError(fmt::format("{} does not hold these structures. Another checkpoint?", options_.restart));
    if (maps_) {
        const std::string notice = maps_->prepare(directory_);
        if (!notice.empty() && !options_.quiet) fmt::print(stderr, "Warning: {}\n", notice);
    }
    if (scene_.output.block_loads)
        loads_ = std::make_unique<LoadRecord<Real, Dim>>(sim_, comm_, directory_ + "/block_loads.bin",
                                                         resume ? std::optional(sim_.clock().step) : std::nullopt);
    // Nobody refuses from here on, so what was there before a refusal is there after it.
    for (CsvLog* table : {history_.get(), balance_.get(), structures_.get(), gauges_.get(), sections_.get()})
        if (table) table->begin();
    std::vector<double> volumes;
    for (const BodySpec& body : scene_.bodies)
        volumes.push_back(body.shape == BodyShape::table ? 0 : measure_of(body, scene_.dimensions));
    write_summary(comm_, directory_ + "/scene.json", surroundings(scene_, volumes));
    if (!series_) return;
    comm_.agree_no_error<MachineError>(message_of([&] {
        if (comm_.is_root() && has_surroundings(scene_))
            replace_file(directory_ + "/surroundings.vtkhdf", surroundings_image(scene_));
    }));
    if (resume) series_->truncate_to(sim_.clock().time);
}

template <class Real, int Dim>
void Driver<Real, Dim>::run() {
    comm_.agree_no_error<MachineError>(
        message_of([&] { watchdog_ = std::make_unique<Watchdog>(scene_.watchdog, comm_.rank(), sim_.phases()); }));
    begin();
    watchdog_->be_patient(false);
    try {
        if (rest_ && !sim_.expects_supply()) rest_->look(sim_);
        while (sim_.clock().time < scene_.end && !ends_at_rest()) advance();
        sim_.conclude();
        sample_maps();
        if (last_output_step_ != sim_.clock().step) output();
        if (!health_.lost_volume().empty()) throw PhysicsError(health_.lost_volume());
    } catch (const PhysicsError&) {
        progress_->clear();
        if (last_output_step_ != sim_.clock().step) output();
        finish("fault");
        throw;
    }
    finish(ends_at_rest() ? "rest" : "end");
}

template <class Real, int Dim>
bool Driver<Real, Dim>::ends_at_rest() const {
    return rest_ && rest_->is_at_rest() && sim_.is_last_stage();
}

/// Anew, where the run or its stage may end at rest.
template <class Real, int Dim>
void Driver<Real, Dim>::watch_rest() {
    const bool looks = sim_.stage() ? sim_.stage()->until_rest : scene_.rest.stops;
    rest_ = looks ? std::make_unique<RestWatch<Dim>>(scene_, comm_) : nullptr;
}

/// The stage before ends with a row of its own.
template <class Real, int Dim>
void Driver<Real, Dim>::begin_stage() {
    sim_.conclude();
    sample_maps();
    if (last_output_step_ != sim_.clock().step) output();
    const bool rests = rest_ && rest_->is_at_rest();
    sim_.begin_stage();
    watch_rest();
    if (!comm_.is_root() || options_.quiet) return;
    progress_->clear();
    fmt::print(stderr, "Stage {} of {}, {}, begins at t = {:.6g} s{}\n", sim_.clock().stages.size(),
               scene_.course.stages.size(), sim_.stage()->name, sim_.clock().time, rests ? ", at rest" : "");
}

template <class Real, int Dim>
void Driver<Real, Dim>::advance() {
    if (sim_.stage_is_over(rest_ && rest_->is_at_rest())) begin_stage();
    if (stop_requested()) sim_.ask(ask_stop);
    const double due = scene_.output.checkpoint_wall_interval;
    if (due > 0 && comm_.is_root() && wall() - last_checkpoint_wall_ >= due) sim_.ask(ask_checkpoint);
    sim_.say_writing(series_ && series_->busy());
    sim_.leave_alone_until(next_look(), std::numeric_limits<std::int64_t>::max());
    const double before = wall_clock();
    sim_.step();
    sim_.balance();
    stepping_ += wall_clock() - before;
    watchdog_->step_finished(sim_.clock().step);
    after_step();
    if (!health_.lost_volume().empty()) throw PhysicsError(health_.lost_volume());
}

/// The time from which after_step() wants the particles.
template <class Real, int Dim>
double Driver<Real, Dim>::next_look() const {
    if (loads_) return 0;  // it counts steps
    double next = scene_.end;
    const auto look = [&](double interval, std::int64_t multiple) {
        if (interval > 0) next = std::min(next, static_cast<double>(multiple) * interval);
    };
    look(scene_.output.interval, next_output_);
    look(scene_.output.checkpoint_interval, next_checkpoint_);
    if (structures_) look(scene_.output.structure_interval, next_structures_);
    if (maps_) next = std::min(next, maps_->next_look());
    if (rest_ && !sim_.expects_supply()) next = std::min(next, rest_->next_look());
    if (sim_.stage()) next = std::min(next, sim_.stage()->until);
    return next;
}

template <class Real, int Dim>
void Driver<Real, Dim>::after_step() {
    const RunClock<Dim>& clock = sim_.clock();
    const double interval = scene_.output.interval;
    const double checkpoint_interval = scene_.output.checkpoint_interval;
    if (series_ && series_->under_way() && sim_.agreement().writing == 0)
        sim_.phases().time(Phase::output, [&] { series_->advance(); });
    if (interval > 0 && clock.time >= static_cast<double>(next_output_) * interval) {
        sim_.conclude();
        output();
    }
    const double often = scene_.output.structure_interval;
    if (structures_ && often > 0 && clock.time >= static_cast<double>(next_structures_) * often) {
        sim_.conclude();
        record_structures();
    }
    if (maps_ && maps_->is_due(clock.time)) sample_maps();
    if (rest_ && !sim_.expects_supply()) rest_->look(sim_);
    if (clock.step % scene_.balance.interval == 0) record_balance();
    const bool due =
        checkpoint_interval > 0 && clock.time >= static_cast<double>(next_checkpoint_) * checkpoint_interval;
    const std::uint32_t asked = sim_.agreement().stop;
    if (due || asked) checkpoint();
    if (asked & ask_stop) {
        finish("signal");
        throw Stopped(fmt::format("Stopped by a signal at step {} (t = {:.6g} s). Go on with --restart {}/{}?",
                                  clock.step, clock.time, directory_, checkpoint_name(clock.step)));
    }
    const double mean = static_cast<double>(sim_.agreement().count_sum) / comm_.size();
    progress_->report({clock.step, clock.time, sim_.counts().particle_steps,
                       mean > 0 ? static_cast<double>(sim_.agreement().count) / mean : 1},
                      wall());
}

template <class Real, int Dim>
void Driver<Real, Dim>::output() {
    sim_.phases().time(Phase::output, [&] {
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
void Driver<Real, Dim>::warn(const TimeSeriesRow<Dim>& row) {
    for (const HealthWarning<Dim>& w :
         health_.observe(row, sim_.clock().start_strain, std::numeric_limits<Real>::epsilon())) {
        if (!comm_.is_root() || options_.quiet) continue;
        progress_->clear();
        fmt::print(stderr, "{}\n", w.message());
    }
}

template <class Real, int Dim>
void Driver<Real, Dim>::checkpoint() {
    if (last_checkpoint_step_ == sim_.clock().step) return;
    sim_.phases().time(Phase::output, [&] {
        sim_.conclude();
        if (path_) path_->write();
        if (series_) series_->finish();  // a restart does not write the outputs before its checkpoint again
        save(sim_, comm_, directory_ + "/" + checkpoint_name(sim_.clock().step),
             {history_->last_row(), health_.stored(), maps_ ? maps_->stored() : std::vector<double>{},
              rest_ ? rest_->stored() : std::vector<std::int64_t>{},
              flow_ ? flow_->stored() : std::vector<std::int64_t>{}, path_ ? path_->stored() : std::vector<double>{},
              changes_});
        if (maps_) maps_->write(directory_, map_tags(sim_, scene_warnings(scene_)));
    });
    last_checkpoint_step_ = sim_.clock().step;
    last_checkpoint_wall_ = wall();
    next_checkpoint_ = next_multiple(scene_.output.checkpoint_interval, sim_.clock().time);
}

template <class Real, int Dim>
void Driver<Real, Dim>::record_structures() {
    sim_.phases().time(Phase::output, [&] { moraine::record_structures(sim_, *structures_); });
    next_structures_ = next_multiple(scene_.output.structure_interval, sim_.clock().time);
}

template <class Real, int Dim>
void Driver<Real, Dim>::sample_maps() {
    if constexpr (Dim == 3) {
        if (!maps_) return;
        sim_.bin();
        const RunClock<Dim>& clock = sim_.clock();
        const auto append = [&](CsvLog& table, const std::vector<double>& values) {
            std::vector<double> row{static_cast<double>(clock.step), clock.time};
            row.insert(row.end(), values.begin(), values.end());
            table.row(row);
        };
        sim_.phases().time(Phase::output, [&] {
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
void Driver<Real, Dim>::record_balance() {
    if (loads_) sim_.phases().time(Phase::output, [&] { loads_->write(); });
    const BalanceRow row = balance_row(sim_, comm_, reported_, reported_seconds_);
    balance_->row(row.values());
    if (row.reason != "memory" || std::exchange(said_memory_, true) || !comm_.is_root() || options_.quiet) return;
    progress_->clear();
    fmt::print(stderr,
               "Warning: at step {} (t = {:.6g} s) no other owners of blocks fit the memory of all ranks, and the load "
               "stays as it is (reason \"memory\" in balance.csv). Go on from a checkpoint on more hosts, or with "
               "larger cells?\n",
               sim_.clock().step, sim_.clock().time);
}

template <class Real, int Dim>
void Driver<Real, Dim>::finish(const std::string& ended_by) {
    const RunClock<Dim>& clock = sim_.clock();
    watchdog_->be_patient(true);
    if (path_) path_->write();
    if (series_) sim_.phases().time(Phase::output, [&] { series_->finish(); });
    if (maps_) maps_->write(directory_, map_tags(sim_, scene_warnings(scene_)));
    progress_->finish({clock.step, clock.time, sim_.counts().particle_steps, 1}, wall());
    const TimeReport times = time_report(sim_, comm_, wall());
    write_summary(comm_, directory_ + "/summary.json",
                  summarize(sim_, comm_, times, stepping_, health_, scene_warnings(scene_), ended_by, changes_));
    if (!comm_.is_root() || options_.quiet) return;
    if (ended_by == "rest") fmt::print(stderr, "{}.\n", rest_->message());
    fmt::print(stderr, "{}Ended by {} at t = {:.6g} s. Results are in {}{}\n", times.text(), ended_by, clock.time,
               directory_, maps_ ? fmt::format(", hazard maps in {}/maps", directory_) : "");
}

namespace {

template <class Real>
void run_precision(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device) {
    if (scene.dimensions == 2)
        Driver<Real, 2>(scene, options, comm, device).run();
    else
        Driver<Real, 3>(scene, options, comm, device).run();
}

}  // namespace

void run_scene(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device) {
    if (scene.precision == Precision::double_)
        run_precision<double>(scene, options, comm, device);
    else
        run_precision<float>(scene, options, comm, device);
}

}  // namespace moraine
