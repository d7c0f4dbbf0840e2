#pragma once
// balance.csv and summary.json: how the run went.

#include <omp.h>

#include "io/csv_log.hpp"
#include "io/json_text.hpp"
#include "records/processor_name.hpp"
#include "records/run_health.hpp"
#include "records/scene_change_record.hpp"
#include "records/structure_record.hpp"
#include "records/time_report.hpp"
#include "records/time_series.hpp"
#include "records/version.hpp"
#include "simulation/diagnostics.hpp"

namespace moraine {

/// One row of balance.csv. What travelled and the seconds are since the row before; the last columns tell of the
/// imbalance check that ended since then: why it was repartitioned or not, what was planned, and what the planner
/// predicted for each kind of plan (not a number: not on offer, or no plan was made).
struct BalanceRow {
    double step = 0, time = 0;
    double particles = 0, particles_min = 0, particles_mean = 0, particles_max = 0, imbalance = 1;
    double blocks = 0, halo_bytes = 0, migrated_particles = 0, migrated_blocks = 0, crossed_particles = 0;
    std::array<double, Phases::count> seconds_mean{}, seconds_max{};
    double repartitioned = 0, planned_imbalance = 0, loses = 0, lost = 0, migration = 0;
    double asleep = -1;  ///< particles; -1: none can in this scene
    double blocks_between_hosts = 0;
    std::string reason, plan;
    std::array<double, plan_kinds> plan_seconds = Plan::not_offered();

    /// with_sleep: of a scene in which blocks can sleep.
    static std::vector<std::string> columns(bool with_sleep = false) {
        std::vector<std::string> names{
            "step",   "time_s",     "particles_min",      "particles_mean",  "particles_max",    "imbalance",
            "blocks", "halo_bytes", "migrated_particles", "migrated_blocks", "crossed_particles"};
        for (const char* phase : Phases::names) {
            names.push_back(std::string(phase) + "_mean_s");
            names.push_back(std::string(phase) + "_max_s");
        }
        for (const char* n : {"repartitioned", "planned_imbalance", "loses_s_per_step", "lost_s", "migration_s",
                              "reason", "plan", "keep_s", "natural_s", "relabelled_s", "least_migration_s"})
            names.push_back(n);
        if (with_sleep) names.insert(names.end(), {"awake", "asleep"});
        names.push_back("blocks_between_hosts");
        return names;
    }

    std::vector<CsvCell> values() const {
        std::vector<CsvCell> v{step,   time,       particles_min,      particles_mean,  particles_max,    imbalance,
                               blocks, halo_bytes, migrated_particles, migrated_blocks, crossed_particles};
        for (std::size_t k = 0; k < Phases::count; ++k) v.insert(v.end(), {seconds_mean[k], seconds_max[k]});
        v.insert(v.end(), {repartitioned, planned_imbalance, loses, lost, migration, reason, plan});
        v.insert(v.end(), plan_seconds.begin(), plan_seconds.end());
        if (asleep >= 0) v.insert(v.end(), {particles - asleep, asleep});
        v.push_back(blocks_between_hosts);
        return v;
    }
};

/// What a rank has of a row: particles, blocks, halo bytes, migrated particles and blocks, crossed particles, blocks
/// whose sums go to other hosts in an exchange; seconds; particles that sleep.
struct RankShare {
    std::array<std::int64_t, 7> counts{};
    std::array<double, Phases::count> seconds{};
    std::int64_t asleep = 0;
};

inline void take_shares(BalanceRow& row, const std::vector<RankShare>& ranks) {
    const auto size = static_cast<double>(ranks.size());
    std::array<std::int64_t, 7> sums{};
    std::int64_t least = ranks.front().counts[0], most = least, asleep = 0, load = 0, largest_load = 0;
    for (const RankShare& rank : ranks) {
        least = std::min(least, rank.counts[0]), most = std::max(most, rank.counts[0]);
        const std::int64_t of_rank = load_of(rank.counts[0], rank.asleep);
        asleep += rank.asleep, load += of_rank, largest_load = std::max(largest_load, of_rank);
        for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += rank.counts[k];
        for (std::size_t k = 0; k < Phases::count; ++k) {
            row.seconds_mean[k] += rank.seconds[k] / size;
            row.seconds_max[k] = std::max(row.seconds_max[k], rank.seconds[k]);
        }
    }
    row.particles_min = static_cast<double>(least);
    row.particles_max = static_cast<double>(most);
    row.particles_mean = static_cast<double>(sums[0]) / size;
    row.particles = static_cast<double>(sums[0]);
    row.asleep = static_cast<double>(asleep);
    const double mean_load = static_cast<double>(load) / size;
    row.imbalance = mean_load > 0 ? static_cast<double>(largest_load) / mean_load : 1;
    double* const totals[] = {&row.blocks,          &row.halo_bytes,        &row.migrated_particles,
                              &row.migrated_blocks, &row.crossed_particles, &row.blocks_between_hosts};
    for (std::size_t k = 0; k < std::size(totals); ++k) *totals[k] = static_cast<double>(sums[k + 1]);
}

/// `reported` and `reported_seconds` are the counts of the row before, and are moved on. Collective.
template <class Real, int Dim>
BalanceRow balance_row(Simulation<Real, Dim>& sim, const Comm& comm, RunCounts& reported,
                       std::array<double, Phases::count>& reported_seconds) {
    const RunCounts now = sim.counts_so_far();
    BalanceRow row;
    row.step = static_cast<double>(sim.clock().step);
    row.time = sim.clock().time;
    const Census census = sim.engine().census();
    RankShare mine;
    mine.counts = {census.particles,
                   census.blocks,
                   now.halo_bytes - reported.halo_bytes,
                   now.migrated_particles - reported.migrated_particles,
                   now.migrated_blocks - reported.migrated_blocks,
                   now.crossed_particles - reported.crossed_particles,
                   now.blocks_between_hosts};
    for (std::size_t k = 0; k < Phases::count; ++k) mine.seconds[k] = sim.phases().all()[k] - reported_seconds[k];
    mine.asleep = census.asleep;
    take_shares(row, comm.all_gather(std::vector<RankShare>{mine}));
    if (!sim.scene().sleep.on) row.asleep = -1;
    const ImbalanceCheck check = sim.take_imbalance_check();
    row.repartitioned = check.repartitioned;
    row.planned_imbalance = check.terms.plan.total > 0 ? check.terms.plan.imbalance() : 0;
    row.loses = check.terms.loses;
    row.lost = check.terms.lost;
    row.migration = check.terms.migration;
    const bool checked = sim.trigger().is_due(sim.clock().step);
    row.reason = !checked ? sim.trigger().decide({}).reason : check.reason.empty() ? "under way" : check.reason;
    row.plan = check.terms.plan.total > 0 ? name_of(check.terms.kind) : "none";
    row.plan_seconds = check.terms.seconds;
    reported = now;
    reported_seconds = sim.phases().all();
    return row;
}

template <int Dim>
Json energies_in_summary(const TimeSeriesRow<Dim>& row) {
    return Json::Named{{"kinetic", row.totals.kinetic},
                       {"strain", row.totals.strain},
                       {"potential", row.potential},
                       {"dissipated", row.dissipated},
                       {"unaccounted", row.unaccounted}};
}

/// of_scene: what was said of it before it ran.
template <int Dim>
Json warnings_in_summary(const RunHealth<Dim>& health, const std::vector<std::string>& of_scene) {
    std::vector<Json> list;
    for (const std::string& message : of_scene) list.push_back(Json::Named{{"problem", "scene"}, {"message", message}});
    for (const HealthWarning<Dim>& w : health.warnings()) list.push_back(w.json());
    return list;
}

template <int Dim>
Json sleep_in_summary(const TimeSeriesRow<Dim>& row, const RunCounts& counts) {
    const double share = counts.particle_steps > 0 ? counts.slept_steps / counts.particle_steps : 0;
    return Json::Named{{"asleep", row.asleep}, {"share_of_particle_steps", share}, {"kinetic_J", row.slept}};
}

/// The stages that have begun.
template <int Dim>
Json stages_in_summary(const Scene& scene, const RunClock<Dim>& clock) {
    std::vector<Json> list;
    for (std::size_t k = 0; k < clock.stages.size(); ++k) {
        const StageBegin& begin = clock.stages[k];
        list.push_back(Json::Named{{"name", scene.course.stages[k].name},
                                   {"begin_s", begin.time},
                                   {"begin_step", begin.step},
                                   {"removed_mass_kg", begin.removed_mass},
                                   {"removed_energy_J", begin.removed_energy},
                                   {"added_mass_kg", begin.added_mass}});
    }
    return list;
}

/// Mean over the steps of this process.
inline double per_step(const RunCounts& counts, double sum) {
    return sum / std::max(1.0, static_cast<double>(counts.steps));
}
inline double mean_imbalance(const RunCounts& counts) {
    return counts.steps > 0 ? std::min(per_step(counts, counts.imbalance_sum), counts.imbalance_max) : 1;
}

/// Of what ranks count each for itself. Collective.
inline std::vector<std::int64_t> sums_of(const RunCounts& counts, const Comm& comm) {
    std::vector<std::int64_t> sums{counts.migrated_particles, counts.crossed_particles, counts.halo_bytes,
                                   counts.clamped_boxes, counts.blocks_between_hosts_sum};
    comm.sum(sums);
    return sums;
}

template <std::size_t Dim>
std::vector<double> list_of(const std::array<double, Dim>& v) {
    return {v.begin(), v.end()};
}

/// What only some runs have.
template <class Real, int Dim>
void add_where_there(Json::Named& summary, Simulation<Real, Dim>& sim, const TimeSeriesRow<Dim>& last,
                     const RunCounts& counts, const std::string& changes) {
    if (sim.scene().sleep.on) summary.emplace_back("sleep", sleep_in_summary(last, counts));
    if (sim.stage()) summary.emplace_back("stages", stages_in_summary(sim.scene(), sim.clock()));
    if (!changes.empty()) summary.emplace_back("changes", changes_in_summary(changes));
    if (!sim.structures().empty()) summary.emplace_back("structures", structures_in_summary(sim));
}

/// changes: of scene_change_record.hpp. Binned state only. Collective.
template <class Real, int Dim>
Json summarize(Simulation<Real, Dim>& sim, const Comm& comm, const TimeReport& times, double stepping,
               const RunHealth<Dim>& health, const std::vector<std::string>& warnings, const std::string& ended_by,
               const std::string& changes) {
    const RunCounts counts = sim.counts_so_far();
    const TimeSeriesRow<Dim> last = observe(sim, comm);
    const std::vector<std::int64_t> sums = sums_of(counts, comm);
    Json::Named summary{
        {"version", version_text},
        {"commit", commit_text},
        {"scene", sim.scene().name},
        {"title", sim.scene().source.title},
        {"machine", processor_name(comm)},
        {"device", sim.engine().device().name},
        {"kernel_compiler", sim.engine().device().compiler},
        {"precision", sizeof(Real) == 8 ? "double" : "single"},
        {"ranks", comm.size()},
        {"threads", omp_get_max_threads()},
        {"partitioner", sim.partitioner().name()},
        {"particles", last.particles},
        {"steps", sim.clock().step},
        {"simulated_time_s", sim.clock().time},
        {"ended_by", ended_by},
        {"wall_s", times.wall},
        {"stepping_s", comm.max(stepping)},
        {"particle_steps_per_s", stepping > 0 ? counts.particle_steps / stepping : 0.0},
        {"imbalance_mean", mean_imbalance(counts)},
        {"imbalance_max", counts.imbalance_max},
        {"imbalance_time_mean", counts.steps > 0 ? per_step(counts, counts.imbalance_time_sum) : 1.0},
        {"repartitions", counts.repartitions},
        {"times_s", times.json()},
        {"migrated_particles", sums[0]},
        {"crossed_particles", sums[1]},
        {"halo_bytes", sums[2]},
        {"hosts", host_count(sim.hosts())},
        {"blocks_between_hosts_mean", per_step(counts, static_cast<double>(sums[4]))},
        {"clamped_boxes", sums[3]},
        {"lost_particles", last.lost_particles},
        {"state_hash", fmt::format("{:016x}", state_hash(sim))},
        {"mass_kg", last.totals.mass},
        {"momentum", list_of(last.totals.momentum)},
        {"momentum_error", list_of(last.momentum_error)},
        {"energies_J", energies_in_summary(last)},
        {"front_m", last.front},
        {"over_filling", health.over_filling()},
        {"warnings", warnings_in_summary(health, warnings)},
    };
    add_where_there(summary, sim, last, counts, changes);
    return summary;
}

}  // namespace moraine
