#include "replay/replay_table.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace moraine {
namespace {

double per(double sum, std::int64_t count) {
    return count > 0 ? sum / static_cast<double>(count) : 0;
}

std::string line_of(const ForecastResult& r) {
    return fmt::format(
        "{:<10}{:>6} "
        "{:<14}{:<10}{:>9.3f}{:>8.3f}{:>10.0f} {:>8.3g}{:>9.0f}{:>7.1f}{:>5}{:>8}{:>12}{:>10.1f}{:>10.4g}{:>7.1f}\n",
        "predicted", r.ranks, r.partitioner, r.trigger, r.imbalance_mean(), r.imbalance_max, per(r.tiles, r.intervals),
        per(r.bytes, r.steps) / 1e6, per(r.face_cut, r.intervals), per(r.neighbours_mean, r.intervals),
        r.neighbours_max, r.repartitions, r.migrated_particles, 1e3 * per(r.plan_seconds, r.plans), r.seconds(),
        100 * r.efficiency());
}

}  // namespace

int refinement_for(std::int64_t feeds, int ranks, int dimensions) {
    int more = 0;
    for (; feeds > 0 && feeds < ranks; ++more) feeds *= std::int64_t(1) << dimensions;
    return more;
}

std::string words_before(const ReplayOptions& options, const ReplayRecord& record) {
    const ForecastResult& run = record.measured();
    const TimeModel& m = record.model();
    std::string text = fmt::format(
        "{}: {} imbalance checks up to step {}, {} to {} blocks; run on {} rank{} with {}.\n"
        "All lines but `measured` are predictions by a model: {:.0f} ns a particle, {:.0f} ns a block, {:.0f} ns a "
        "particle in exchanges, {:.2g} ms an imbalance check,\n  {:.2g} ms a step, a migration {:.2g} times what the "
        "planner reckons, timing noise {:.1f} %;\n  network {:.2g} us and {:.2g} GB/s (--latency, "
        "--bandwidth).\n",
        options.directory, record.checks(), record.last_step(), record.blocks_min(), record.blocks_max(), run.ranks,
        run.ranks == 1 ? "" : "s", run.partitioner, 1e9 * m.particle, 1e9 * m.block, 1e9 * m.exchange, 1e3 * m.check,
        1e3 * m.constant, m.moves_slower, 100 * m.timing_noise, 1e6 * m.network.latency, m.network.bandwidth / 1e9);
    if (m.ranks_per_host > 0)
        text += fmt::format(
            "Hosts of {} rank{} in a row: that network is between them, within one {:.2g} us and {:.2g} GB/s "
            "(--latency-within, --bandwidth-within).\n",
            m.ranks_per_host, m.ranks_per_host == 1 ? "" : "s", 1e6 * m.within.latency, m.within.bandwidth / 1e9);
    if (record.asleep_share() > 0 || options.sleep)
        text +=
            fmt::format("Of the particle-steps {:.1f} % {}; {} sleeping particles weigh as much as one.\n",
                        100 * record.asleep_share(), record.slept() ? "slept" : "would have slept", sleepers_per_awake);
    if (options.refine > 0)
        text += fmt::format(
            "Loads are those of a grid {} times finer that nobody ran: every block divided, with as many particles in "
            "each part.\n",
            1 << options.refine);
    if (record.blocks_between_checks() > 1)
        text += fmt::format(
            "Warning: between two imbalance checks the flow crosses {:.2g} blocks of this grid (owners are then "
            "guessed, and imbalances come out too large). Record it with balance.interval = {}?\n",
            record.blocks_between_checks(),
            std::max(1, static_cast<int>(record.balance().interval * options.every / record.blocks_between_checks())));
    for (const int ranks : options.ranks)
        if (const int more = refinement_for(record.feeds_always(), ranks, record.layout().dimensions); more > 0)
            text += fmt::format("Notice: {} ranks want --refine {}: cells {} times smaller than the run's.\n", ranks,
                                options.refine + more, 1 << (options.refine + more));
    return text + fmt::format(
                      "This scene can feed {} ranks at its start and {} at its worst imbalance check (heaviest rank at "
                      "most {} "
                      "times the mean, "
                      "Morton curve).\n\n",
                      record.feeds_at_start(), record.feeds_always(), ReplayRecord::feed_limit);
}

std::string table_text(const ReplayRecord& record, const std::vector<ForecastResult>& results) {
    std::string text =
        fmt::format("{:<10}{:>6} {:<14}{:<10}{:>17}{:>19}{:>9}{:>12}{:>20}{:>10}{:>10}{:>7}\n", "", "", "", "",
                    "imbalance", "halo", "face", "neighbours", "repart  particles", "plan", "time", "eff.");
    text += fmt::format("{:<10}{:>6} {:<14}{:<10}{:>9}{:>8}{:>10}{:>9}{:>9}{:>7}{:>5}{:>8}{:>12}{:>10}{:>10}{:>7}\n",
                        "", "ranks", "partitioner", "trigger", "mean", "worst", "tiles", "MB/step", "cut", "mean",
                        "max", "itions", "moved", "[ms]", "[s]", "[%]");
    const ForecastResult& run = record.measured();
    text += fmt::format("{:<10}{:>6} {:<14}{:<10}{:>9.3f}{:>8.3f}{:>76.4g}\n", "measured", run.ranks, run.partitioner,
                        "", run.imbalance_mean(), run.imbalance_max, record.measured_seconds());
    for (const ForecastResult& r : results) text += line_of(r);
    return text;
}

std::string regret_text(const std::vector<RegretRow>& rows) {
    if (rows.empty()) return "";
    std::string text =
        "\nRegret: predicted time of computing and migration above that of the best times to repartition, known "
        "afterwards.\n";
    for (const RegretRow& r : rows)
        text += fmt::format("{:<10}{:>6} {:<14}{:<10}{:>6} repartitions {:>10.4g} s  {:+.2f} %\n", "predicted", r.ranks,
                            r.partitioner, r.trigger, r.repartitions, r.seconds, r.percent());
    return text;
}

std::string csv_text(const ReplayRecord& record, const std::vector<ForecastResult>& results,
                     const std::vector<RegretRow>& rows) {
    std::string text =
        "kind,ranks,partitioner,trigger,imbalance_mean,imbalance_max,imbalance_time_mean,halo_tiles,halo_bytes,face_"
        "cut,"
        "neighbours_mean,neighbours_max,repartitions,migrated_particles,migrated_blocks,plan_mean_s,plan_max_s,"
        "computing_s,"
        "timing_noise_s,ideal_s,sending_s,migration_s,checks_s,time_s,efficiency,regret_percent,halo_tiles_between_"
        "hosts,asleep_share\n";
    const ForecastResult& run = record.measured();
    text += fmt::format("measured,{},{},,{},{},,,{},,,,,,,,,,,,,,,{},,,,{}\n", run.ranks, run.partitioner,
                        run.imbalance_mean(), run.imbalance_max, run.bytes, record.measured_seconds(),
                        record.slept() ? record.asleep_share() : 0);
    for (const ForecastResult& r : results)
        text += fmt::format(
            "predicted,{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},,{},{}\n", r.ranks,
            r.partitioner, r.trigger, r.imbalance_mean(), r.imbalance_max, per(r.imbalance_time_sum, r.steps),
            per(r.tiles, r.intervals), r.bytes, per(r.face_cut, r.intervals), per(r.neighbours_mean, r.intervals),
            r.neighbours_max, r.repartitions, r.migrated_particles, r.migrated_blocks, per(r.plan_seconds, r.plans),
            r.plan_seconds_max, r.computing, r.timing_noise, r.ideal, r.sending, r.migration, r.checking, r.seconds(),
            r.efficiency(), per(r.tiles_between, r.intervals), record.asleep_share());
    for (const RegretRow& r : rows)
        text += fmt::format("regret,{},{},{},,,,,,,,,{},,,,,,,,,,,{},,{},,\n", r.ranks, r.partitioner, r.trigger,
                            r.repartitions, r.seconds, r.percent());
    return text;
}

}  // namespace moraine
