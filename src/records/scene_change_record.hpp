#pragma once
// What restarts have changed of a scene so far: kept in checkpoints as text, told in summary.json. A line per change,
// its words apart by tabs: step, time, key, what it was and what it is; values of the identity have no tabs.

#include <fmt/format.h>

#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "io/json_text.hpp"
#include "scene/scene_changes.hpp"
#include "scene/scene_identity.hpp"

namespace moraine {

/// With the changes made at this step and time [s] behind those of before.
inline std::string with_changes(std::string before, const std::vector<SceneChange>& changes, std::int64_t step,
                                double time) {
    for (const SceneChange& c : changes) before += fmt::format("{}\t{}\t{}\t{}\t{}\n", step, time, c.key, c.was, c.is);
    return before;
}

/// For summary.json: {step, time_s, key, was, is} of each, values as text.
inline Json changes_in_summary(const std::string& record) {
    std::vector<Json> list;
    std::istringstream lines(record);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::int64_t step = 0;
        double time = 0;
        std::string key, was, is;
        words >> step >> time >> std::ws;
        std::getline(words, key, '\t');
        std::getline(words, was, '\t');
        std::getline(words, is, '\t');
        list.push_back(Json::Named{
            {"step", step}, {"time_s", time}, {"key", key}, {"was", in_words(key, was)}, {"is", in_words(key, is)}});
    }
    return list;
}

}  // namespace moraine
