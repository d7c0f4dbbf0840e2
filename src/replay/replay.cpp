#include "replay/replay.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>

#include "core/data/error.hpp"
#include "io/disk_file.hpp"
#include "replay/optimum.hpp"
#include "replay/replay_record.hpp"
#include "replay/replay_table.hpp"

namespace moraine {
namespace {

std::vector<int> chosen_ranks(const ReplayOptions& options, const ReplayRecord& record) {
    std::vector<int> ranks = options.ranks;
    if (ranks.empty())
        for (std::int64_t p = 4; p <= record.blocks_min() && p <= 16384; p *= 4) ranks.push_back(static_cast<int>(p));
    if (ranks.empty()) ranks.push_back(1);
    for (const int p : ranks)
        if (p > record.blocks_max())
            throw InputError(
                fmt::format("--ranks {} (a rank needs a block, and no imbalance check has more than {}). At most {}, "
                            "or --refine {}?",
                            p, record.blocks_max(), record.blocks_max(),
                            options.refine + refinement_for(record.blocks_max(), p, record.layout().dimensions)));
    return ranks;
}

/// Those that need no library, the run's own first.
std::vector<std::string> chosen_partitioners(const ReplayOptions& options, const ReplayRecord& record) {
    if (!options.partitioners.empty()) return options.partitioners;
    std::vector<std::string> names{record.balance().partitioner};
    for (const char* name : {"morton", "hilbert", "equal-slabs", "slabs", "slabs-initial", "cartesian"})
        if (name != names.front()) names.push_back(name);
    return names;
}

std::vector<ForecastResult> forecast_all(const ReplayOptions& options, const ReplayRecord& record) {
    std::vector<Forecast> forecasts;
    for (const int ranks : chosen_ranks(options, record))
        for (const std::string& name : chosen_partitioners(options, record)) {
            BalanceSpec spec = record.balance();
            spec.partitioner = name;
            bool is_static = false;
            const auto add = [&](Trigger trigger) {
                if (is_static) return;  // one line: it ignores the trigger
                spec.trigger = trigger;
                forecasts.emplace_back(spec, record.layout(), record.weights(), ranks, record.model());
                is_static = forecasts.back().partitioner().is_static();
            };
            if (options.triggers.empty()) add(spec.trigger);
            for (const Trigger trigger : options.triggers) add(trigger);
        }
    record.each_check([&](Interval& now, const Carry& carry) {
        for (Forecast& forecast : forecasts) forecast.check(now, carry);
        const HaloSurroundings around(record.layout(), now.blocks);
        for (Forecast& forecast : forecasts) forecast.add_halo(around, record.node_bytes());
    });
    std::vector<ForecastResult> results;
    for (const Forecast& forecast : forecasts) results.push_back(forecast.result());
    return results;
}

/// All triggers with relabelled cuts, and the optimum of the same.
std::vector<RegretRow> regrets_of(const BalanceSpec& balance, const ReplayRecord& record, int ranks,
                                  std::vector<Interval>& intervals, const std::vector<Carry>& carries) {
    BalanceSpec spec = balance;
    const Optimum best =
        offline_optimum(spec, record.layout(), record.weights(), ranks, record.model(), intervals, carries);
    std::vector<RegretRow> rows{{ranks, spec.partitioner, "optimum", best.repartitions, best.seconds, best.seconds}};
    for (const Trigger trigger : {Trigger::never, Trigger::every, Trigger::threshold, Trigger::planned}) {
        spec.trigger = trigger;
        Forecast forecast(spec, record.layout(), record.weights(), ranks, record.model(), true);
        for (std::size_t k = 0; k < intervals.size(); ++k) forecast.check(intervals[k], carries[k]);
        const ForecastResult& r = forecast.result();
        rows.push_back({ranks, spec.partitioner, r.trigger, r.repartitions, r.computing + r.migration, best.seconds});
    }
    return rows;
}

std::vector<RegretRow> all_regrets(const ReplayOptions& options, const ReplayRecord& record) {
    std::vector<RegretRow> rows;
    if (!options.regret) return rows;
    std::vector<Interval> intervals;
    std::vector<Carry> carries;
    record.each_check([&](const Interval& now, const Carry& carry) {
        intervals.push_back(now);
        carries.push_back(carry);
    });
    for (const int ranks : chosen_ranks(options, record))
        for (const std::string& name : chosen_partitioners(options, record)) {
            BalanceSpec spec = record.balance();
            spec.partitioner = name;
            // phg's cut depends on the owners before: there is no optimum to be had by this programme.
            if (name == "phg" || make_partitioner(spec, record.layout(), ranks)->is_static()) continue;
            for (RegretRow& row : regrets_of(spec, record, ranks, intervals, carries)) rows.push_back(std::move(row));
        }
    return rows;
}

}  // namespace

void replay(const ReplayOptions& options) {
    omp_set_num_threads(1);  // its parallel loops are short: other threads would only spin
    const ReplayRecord record(options);
    chosen_ranks(options, record);  // wrong use is refused before anything is said
    fmt::print("{}", words_before(options, record));
    const std::vector<ForecastResult> results = forecast_all(options, record);
    fmt::print("{}", table_text(record, results));
    const std::vector<RegretRow> regrets = all_regrets(options, record);
    fmt::print("{}", regret_text(regrets));
    const std::string path = options.output.empty() ? options.directory + "/replay.csv" : options.output;
    replace_file(path, csv_text(record, results, regrets));
    fmt::print("\nThe table is in {}\n", path);
}

}  // namespace moraine
