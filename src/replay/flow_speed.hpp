#pragma once
// How fast the flow of a run is on its grid, by what the run left: history.csv and scene.json.

#include <string>

namespace moraine {

/// Cells that the fastest particle goes through in a step, in the mean of the rows of history.csv; 0 where that cannot
/// be known.
double cells_per_step(const std::string& directory);

}  // namespace moraine
