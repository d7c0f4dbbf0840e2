#include "app/driver.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <limits>
#include <utility>

#include "app/disk_space.hpp"
#include "app/trace_file.hpp"
#include "predict/capacity.hpp"
#include "predict/scene_warnings.hpp"

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

}  // namespace

template <class Real, int Dim>
Driver<Real, Dim>::Driver(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device,
                          Watchdog& watchdog)
    : scene_(scene),
      options_(options),
      comm_(comm),
      directory_(options.output.empty() ? default_run_directory(scene.name) : options.output),
      device_message_(device.message),
      sim_(scene, comm, device.cuda ? device_engine_maker<Real, Dim>(scene, comm, device) : nullptr),
      records_(scene, options, sim_, directory_, [this](const std::string& text) { say(text); }),
      watchdog_(watchdog),
      watched_(watchdog, sim_.phases()) {
    // Moves within one host leave its memory as full as it was.
    if (!device.cuda && host_count(sim_.hosts()) > 1)
        sim_.hold_at_most(particles_in_memory(scene, {comm.size(), comm.on_this_machine().size, host_memory()}));
    watch_rest();
    sim_.phases().tell(device_profiler());
    if (!options.trace.empty()) timeline_ = std::make_unique<Timeline>(spans_of_rank(comm.size()));
    sim_.phases().record(timeline_.get());
}

template <class Real, int Dim>
double Driver<Real, Dim>::wall() const {
    return wall_clock() - start_wall_;
}

template <class Real, int Dim>
void Driver<Real, Dim>::say(const std::string& text) {
    if (!comm_.is_root() || options_.quiet) return;
    if (progress_) progress_->clear();
    fmt::print(stderr, "{}\n", text);
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
    if (timeline_) check_trace_file(comm_, options_.trace, directory_, options_.overwrite);
    RestartedRecords before;
    if (restarting) {
        const CheckpointReader file(comm_, options_.restart);
        before = records_.restore(file);
        watch_rest();
        if (rest_ && !before.rest.empty() && !rest_->restore(before.rest)) file.refuse("no run rests so");
        if (claim != RunClaim::resume) before.path_rows.clear();
    } else {
        sim_.seed();
    }
    if (!sim_.trigger().notice().empty()) say(sim_.trigger().notice());
    lock_ = claim_run_directory(comm_, directory_, claim);
    catch_stop_signals();
    if (comm_.is_root() && !options_.quiet) {
        std::vector<std::string> warnings = scene_warnings(scene_);
        if (!options_.no_particles)
            warnings.push_back(disk_warning(scene_, sim_.clock().time, free_disk_bytes(directory_)));
        for (const std::string& warning : warnings)
            if (!warning.empty()) say("Warning: " + warning);
        say(device_message_);
    }
    const RunClock<Dim>& clock = sim_.clock();
    std::optional<ResumeAfter> resume;
    if (claim == RunClaim::resume) resume = ResumeAfter{"step", static_cast<double>(clock.step), before.history_row};
    records_.open(resume, before.path_rows);
    next_checkpoint_ = next_multiple(scene_.output.checkpoint_interval, clock.time);
    progress_ = std::make_unique<Progress>(Progress::style_for(options_.quiet, comm_.is_root()), clock.time, scene_.end,
                                           wall());
    records_.begin(restarting, resume.has_value());
}

template <class Real, int Dim>
void Driver<Real, Dim>::run() {
    if (timeline_) {
        comm_.barrier();  // time zero of all
        timeline_->start();
    }
    sim_.phases().group({"start", true}, [&] { begin(); });
    watchdog_.be_patient(false);
    try {
        if (rest_ && !sim_.expects_supply()) rest_->look(sim_);
        while (sim_.clock().time < scene_.end && !ends_at_rest()) advance();
        watchdog_.be_patient(true);
        sim_.conclude();
        records_.end_part();
        check_volume();
    } catch (const PhysicsError&) {
        watchdog_.be_patient(true);
        progress_->clear();
        records_.output_last();
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
    records_.end_part();
    const bool rests = rest_ && rest_->is_at_rest();
    watchdog_.be_patient(true);
    sim_.begin_stage();
    watchdog_.be_patient(false);
    watch_rest();
    say(fmt::format("Stage {} of {}, {}, begins at t = {:.6g} s{}", sim_.clock().stages.size(),
                    scene_.course.stages.size(), sim_.stage()->name, sim_.clock().time, rests ? ", at rest" : ""));
}

template <class Real, int Dim>
void Driver<Real, Dim>::advance() {
    if (sim_.stage_is_over(rest_ && rest_->is_at_rest())) begin_stage();
    if (stop_requested()) sim_.ask(ask_stop);
    const double due = scene_.output.checkpoint_wall_interval;
    if (due > 0 && comm_.is_root() && wall() - last_checkpoint_wall_ >= due) sim_.ask(ask_checkpoint);
    sim_.say_writing(records_.is_writing());
    sim_.leave_alone_until(next_look(), std::numeric_limits<std::int64_t>::max());
    if (timeline_) timeline_->begin_step(sim_.clock().step);
    const double before = wall_clock();
    sim_.phases().group("step", [&] { sim_.step(); });
    sim_.balance();
    stepping_ += wall_clock() - before;
    watchdog_.step_finished(sim_.clock().step);
    after_step();
    check_volume();
}

template <class Real, int Dim>
void Driver<Real, Dim>::check_volume() const {
    if (!records_.lost_volume().empty()) throw PhysicsError(records_.lost_volume());
}

/// The time from which after_step() wants the particles.
template <class Real, int Dim>
double Driver<Real, Dim>::next_look() const {
    double next = records_.next_look();
    const double interval = scene_.output.checkpoint_interval;
    if (interval > 0) next = std::min(next, static_cast<double>(next_checkpoint_) * interval);
    if (rest_ && !sim_.expects_supply()) next = std::min(next, rest_->next_look());
    if (sim_.stage()) next = std::min(next, sim_.stage()->until);
    return next;
}

template <class Real, int Dim>
void Driver<Real, Dim>::after_step() {
    const RunClock<Dim>& clock = sim_.clock();
    const double checkpoint_interval = scene_.output.checkpoint_interval;
    records_.after_step();
    if (rest_ && !sim_.expects_supply()) rest_->look(sim_);
    if (clock.step % scene_.balance.interval == 0) records_.record_balance();
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
void Driver<Real, Dim>::checkpoint() {
    if (last_checkpoint_step_ == sim_.clock().step) return;
    records_.checkpoint(rest_ ? rest_->stored() : std::vector<std::int64_t>{});
    last_checkpoint_step_ = sim_.clock().step;
    last_checkpoint_wall_ = wall();
    next_checkpoint_ = next_multiple(scene_.output.checkpoint_interval, sim_.clock().time);
}

template <class Real, int Dim>
void Driver<Real, Dim>::finish(const std::string& ended_by) {
    const RunClock<Dim>& clock = sim_.clock();
    watchdog_.be_patient(true);
    records_.finish();
    progress_->finish({clock.step, clock.time, sim_.counts().particle_steps, 1}, wall());
    const std::string times = records_.summarize(ended_by, wall(), stepping_);
    if (timeline_) write_trace(comm_, options_.trace, *timeline_, scene_.name, sim_.engine().device().name);
    if (!comm_.is_root() || options_.quiet) return;
    if (ended_by == "rest") fmt::print(stderr, "{}.\n", rest_->message());
    fmt::print(stderr, "{}Ended by {} at t = {:.6g} s. Results are in {}{}\n", times, ended_by, clock.time, directory_,
               records_.has_maps() ? fmt::format(", hazard maps in {}/maps", directory_) : "");
}

namespace {

template <class Real>
void run_precision(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device,
                   Watchdog& watchdog) {
    if (scene.dimensions == 2)
        Driver<Real, 2>(scene, options, comm, device, watchdog).run();
    else
        Driver<Real, 3>(scene, options, comm, device, watchdog).run();
}

}  // namespace

void run_scene(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device,
               Watchdog& watchdog) {
    if (scene.precision == Precision::double_)
        run_precision<double>(scene, options, comm, device, watchdog);
    else
        run_precision<float>(scene, options, comm, device, watchdog);
}

}  // namespace moraine
