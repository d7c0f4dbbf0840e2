#pragma once
// The weight of a block, which the cut balances.
//
//   particles   the number of its particles
//   cost        a * particles + c * occupied cells + d, rounded to whole nanoseconds, at least 1
//   time        a * (particles + b), in picoseconds, at least 1
//
// a of `time` is measured by the rank that holds the block (measured_cost.hpp); b are as many particles as take the
// time that a full block takes besides its own, by the constants of `cost`.
//
// The constants are whole picoseconds: a device needs about 100 ps per particle, and integers give
// the same weight on every rank. Those of `cost` are refined by measured steps (calibration.hpp), the same on all
// ranks.

#include <algorithm>
#include <cstdint>

#include "core/scene_spec.hpp"

namespace moraine {

/// Time of a step.
struct CostModel {
    std::int64_t a;  ///< per particle [ps]
    std::int64_t c;  ///< per occupied cell [ps]
    std::int64_t d;  ///< per block [ps]
};

/// Sleeping particles (core/sleep/sleep.hpp) that cost as much as one that is awake: their blocks still have nodes and
/// lists.
inline constexpr std::int64_t sleepers_per_awake = 16;

/// Particles of a rank by what they cost.
constexpr std::int64_t load_of(std::int64_t particles, std::int64_t asleep) {
    return particles - asleep + (asleep + sleepers_per_awake - 1) / sleepers_per_awake;
}

/// On one core, from benchmark_step --costs: the cell term came out as nothing.
inline constexpr CostModel host_costs{130000, 0, 8000000};
/// On one H200 in single: least squares over benchmark_device's cases costs-* (benchmarks/device/results.md)
/// with what a step takes whatever its share is (0.1 ms), which no cut changes; in double about twice that. Cuts depend
/// on the ratio alone, and measured steps set the scale.
inline constexpr CostModel device_costs{81, 296, 0};

class BlockWeight {
  public:
    /// cells: of a block. Throws InputError if balance.weight is none of these. Not collective.
    BlockWeight(const BalanceSpec& spec, const CostModel& model, int cells = 64);

    /// Not collective.
    std::int64_t operator()(std::int64_t particles, std::int64_t cells) const {
        if (kind_ == Kind::particles) return particles;
        if (kind_ == Kind::time) return std::max<std::int64_t>(1, model_.a * with_blocks(particles, 1));
        const std::int64_t picoseconds = model_.a * particles + model_.c * cells + model_.d;
        const std::int64_t nanoseconds = (picoseconds + 500) / 1000;
        return nanoseconds > 0 ? nanoseconds : 1;
    }

    /// Particles, and for each block as many as `time` adds.
    std::int64_t with_blocks(std::int64_t particles, std::int64_t blocks) const { return particles + blocks * block_; }

    bool is_cost() const { return kind_ == Kind::cost; }
    bool is_time() const { return kind_ == Kind::time; }
    const CostModel& model() const { return model_; }
    void set_model(const CostModel& model) { model_ = model; }

    /// What a unit of weight takes in a step, by the model [s].
    double seconds() const {
        if (kind_ == Kind::particles) return static_cast<double>(model_.a) * 1e-12;
        return kind_ == Kind::cost ? 1e-9 : 1e-12;
    }

  private:
    enum class Kind { particles, cost, time };

    Kind kind_ = Kind::particles;
    CostModel model_;
    std::int64_t block_;  ///< particles that take as long as a block does besides its own
};

}  // namespace moraine
