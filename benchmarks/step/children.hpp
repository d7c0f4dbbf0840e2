#pragma once
// Each case in a process of its own: peak memory is a property of a process, and no case inherits the
// heap of the one before. A child prints three lines: JSON, table row, numbers.

#include <string>

#include "step/measure.hpp"
#include "step/scenes.hpp"

namespace moraine {

struct ChildResult {
    std::string json;
    std::string row;
    double particles, cells, blocks;
    double step_seconds;  ///< processor time of the median run, per step
    std::int64_t peak_bytes;
};

/// Runs this program again for one case. Throws std::runtime_error if that fails.
ChildResult run_child(const std::string& name, double particles, const Runs& plan, std::int64_t empty_bytes);

/// What the child does: measure the case of that name and print.
void be_child(const std::string& name, double particles, const Runs& plan, std::int64_t empty_bytes);

}  // namespace moraine
