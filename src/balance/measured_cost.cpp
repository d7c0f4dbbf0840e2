#include "balance/measured_cost.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace moraine {

namespace {

constexpr double fading = 1 - 1.0 / 64;  ///< per step: longer than a step's noise, shorter than a flow's changes

}  // namespace

void MeasuredCost::add(const StepTimes& step) {
    if (std::exchange(skips_, false)) return;
    const auto sum = [](double& to, double x) { to = fading * to + x; };
    sum(mine_, step.mine), sum(slowest_, step.slowest), sum(sum_, step.sum);
    sum(my_particles_, static_cast<double>(step.my_particles)), sum(particles_, static_cast<double>(step.particles));
}

std::int64_t MeasuredCost::picoseconds(std::int64_t start) const {
    if (sum_ <= 0 || particles_ <= 0) return start;
    const double mean = sum_ / particles_;
    const double mine = my_particles_ > 0 ? mine_ / my_particles_ : mean;
    return std::max<std::int64_t>(1, std::llround(1e12 * std::clamp(mine, mean / 2, 2 * mean)));
}

LoadSummary MeasuredCost::load(int ranks) const {
    return {std::llround(1e12 * slowest_), std::llround(1e12 * sum_), ranks};
}

}  // namespace moraine
