#pragma once
// The results of a replay as lines for people and as a table for programs (replay.csv).

#include <string>
#include <vector>

#include "replay/forecast.hpp"
#include "replay/optimum.hpp"
#include "replay/replay_record.hpp"

namespace moraine {

/// One trigger against the best times to repartition: seconds of computing and migration.
struct RegretRow {
    int ranks;
    std::string partitioner, trigger;
    std::int64_t repartitions;
    double seconds, optimum;

    double percent() const { return optimum > 0 ? 100 * (seconds / optimum - 1) : 0; }
};

/// How often cells must be halved beyond now, for `feeds` ranks to become as many as are wanted.
int refinement_for(std::int64_t feeds, int ranks, int dimensions);

/// What the record holds, the model, and how many ranks the scene can feed.
std::string words_before(const ReplayOptions& options, const ReplayRecord& record);

std::string table_text(const ReplayRecord& record, const std::vector<ForecastResult>& results);
std::string regret_text(const std::vector<RegretRow>& rows);

/// The first line names the columns; `kind` is measured, predicted, or regret.
std::string csv_text(const ReplayRecord& record, const std::vector<ForecastResult>& results,
                     const std::vector<RegretRow>& rows);

}  // namespace moraine
