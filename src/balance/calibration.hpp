#pragma once
// The cost of a block, refined by measured steps: where ranks hold different mixes of particles, cells and blocks,
// their computing times tell what each costs.
//
// Minimises  sum over samples  (1 - (a P + c C + d B) / t)^2  +  lambda sum over terms  (x / x_0 - s)^2
//
// t measured, x_0 the constants that the build brings (a term that is 0 there stays 0) and s = sum t / sum of what x_0
// predicts. So a slower machine only scales the model, ranks of one mix leave its proportions alone, and a term is at
// least a tenth of its proportion. Older samples fade. Not a library's least squares: three unknowns.

#include <array>
#include <span>

#include "balance/weight.hpp"

namespace moraine {

/// A rank's share and its computing time per step.
struct CostSample {
    double particles = 0;
    double cells = 0;
    double blocks = 0;
    double seconds = 0;  ///< 0: nothing was measured
};

class Calibration {
  public:
    explicit Calibration(const CostModel& start) : start_(start) {}

    /// Samples of all ranks, the same on all of them. Not collective.
    void add(std::span<const CostSample> samples);

    /// The constants given at first until there are samples. Not collective.
    CostModel model() const;

  private:
    static constexpr std::size_t terms = 3;
    std::array<double, terms> predicted(const CostSample& s) const;

    CostModel start_;
    std::array<std::array<double, terms>, terms> normal_{};  ///< sums of products of features
    std::array<double, terms> right_{};
    double measured_ = 0, expected_ = 0;  ///< [s]
};

}  // namespace moraine
