#pragma once
// The cost of a block on one core, for balance.weight = "cost":
//
//   T = a particles + c cells + d blocks      least squares of the relative error over the cost cases
//
// A cell that seems to cost less than nothing is left out of the fit.

#include <string>
#include <vector>

#include "balance/weight.hpp"
#include "step/children.hpp"

namespace moraine {

/// Whole picoseconds.
CostModel fit_costs(const std::vector<ChildResult>& cases);

/// The fit and its error in each case, as a table.
std::string cost_table(const CostModel& model, const std::vector<Case>& names, const std::vector<ChildResult>& cases);

}  // namespace moraine
