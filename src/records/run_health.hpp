#pragma once
// What a run says of itself when its answer is no longer to be trusted: looked at in each row of history.csv.
//
//   volume  a particle of a nearly incompressible material (Poisson's ratio from 0.45 on) has less than half or more
//           than twice its volume
//   energy  more energy than there was: unaccounted_J below -1 % of the most that was ever in motion, stored or
//           dissipated, in two rows in turn. In one row it may be the step's own phase: velocities are half a step
//           apart from stresses. Not judged once particles have left through open walls: what they took is not known;
//           nor with gravity along a periodic axis: the potential energy jumps where particles come round
//   filling more than 5 % of the volume does not fit where its particles are (core/fluid/over_filling.hpp)
//
// Each is said once. What is kept of it goes into checkpoints, so a restarted run neither forgets nor repeats it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "io/json_text.hpp"
#include "records/time_series.hpp"

namespace moraine {

enum class HealthProblem { volume, energy, filling };

/// One thing that went wrong, where and when it was first seen.
template <int Dim>
struct HealthWarning {
    HealthProblem problem = HealthProblem::volume;
    double amount = 0;  ///< volume: |ln J|; energy: gain over what was in motion; filling: share of the volume [-]
    std::int64_t step = 0;
    double time = 0;              ///< [s]
    std::array<double, Dim> x{};  ///< of the particle; of energy and filling: of the fastest one [m]

    std::string name() const {
        constexpr const char* names[] = {"volume", "energy", "filling"};
        return names[static_cast<int>(problem)];
    }

    std::string message() const {
        std::string place;
        for (const double at : x) place += fmt::format("{}{:.6g}", place.empty() ? "" : ", ", at);
        const std::string when = fmt::format("at step {} (t = {:.6g} s)", step, time);
        if (problem == HealthProblem::volume)
            return fmt::format(
                "Warning: {} a particle at ({}) m of a nearly incompressible material has changed its volume {:.3g} "
                "times (J; up to 2 is sound). What follows is doubtful. Try numerics.light_nodes = \"limited\", a "
                "smaller time.cfl or smaller cells?",
                when, place, std::exp(amount));
        if (problem == HealthProblem::filling)
            return fmt::format(
                "Warning: {} {:.2g} % of the volume does not fit where its particles are (over_filling in "
                "history.csv), "
                "and fronts fall short by it. For fluids try material.particle_shifting?",
                when, 100 * amount);
        return fmt::format(
            "Warning: {} there is {:.2g} % more energy than there was (unaccounted_J in history.csv; the fastest "
            "particle is at ({}) m). What follows is doubtful. Try numerics.light_nodes = \"limited\", a smaller "
            "time.cfl or numerics.transfer = \"apic\"?",
            when, 100 * amount, place);
    }

    Json json() const {
        return Json::Named{{"problem", name()},
                           {"amount", amount},
                           {"step", step},
                           {"time_s", time},
                           {"place_m", std::vector<double>(x.begin(), x.end())}};
    }
};

template <int Dim>
class RunHealth {
  public:
    static constexpr double most_stretch = 0.6931471805599453;  ///< |ln J| of twice or half the volume
    static constexpr double most_gain = 0.01;
    static constexpr double most_filling = 0.05;

    /// What to say where a particle has less than a thousandth or more than a thousand times of its volume: nothing
    /// that follows means anything, whatever the method. Empty: none has.
    static std::string lost_volume_in(const TimeSeriesRow<Dim>& row) {
        const Totals<Dim>& t = row.totals;
        if (row.particles == 0 || (t.min_J >= 1e-3 && t.max_J <= 1e3)) return {};
        return fmt::format(
            "a particle has lost its volume at step {} (t = {:.6g} s: J is from {:.3g} to {:.3g}, and beyond 1e-3 to "
            "1e3 "
            "nothing means anything). Try material.volumetric = \"grid\", a smaller time.cfl or smaller cells?",
            row.step, row.time, t.min_J, t.max_J);
    }

    /// rounding: of the run's reals, their epsilon. start_strain: stored at the start [J]. What is new.
    std::vector<HealthWarning<Dim>> observe(const TimeSeriesRow<Dim>& row, double start_strain, double rounding) {
        std::vector<HealthWarning<Dim>> found;
        const Totals<Dim>& t = row.totals;
        lost_volume_ = lost_volume_in(row);
        if (!(t.stretch.value <= most_stretch) && !has(HealthProblem::volume))
            found.push_back({HealthProblem::volume, t.stretch.value, row.step, row.time, t.stretch.x});
        const double gain = gain_of(row, start_strain, rounding);
        if (gain > most_gain && last_gain_ > most_gain && !has(HealthProblem::energy))
            found.push_back({HealthProblem::energy, gain, row.step, row.time, t.speed.x});
        last_gain_ = gain;
        if (row.over_filling > most_filling && !has(HealthProblem::filling))
            found.push_back({HealthProblem::filling, row.over_filling, row.step, row.time, t.speed.x});
        over_filling_ = std::fmax(over_filling_, row.over_filling);
        warnings_.insert(warnings_.end(), found.begin(), found.end());
        return found;
    }

    const std::vector<HealthWarning<Dim>>& warnings() const { return warnings_; }
    /// lost_volume_in() the last row.
    const std::string& lost_volume() const { return lost_volume_; }
    /// The largest share of the rows; not a number where none has one.
    double over_filling() const { return over_filling_; }

    /// For a checkpoint: the energy so far, the last gain, the largest over-filling (-1: none), and problem, amount,
    /// step, time, place of each warning.
    std::vector<double> stored() const {
        std::vector<double> all{moved_, last_gain_, std::isnan(over_filling_) ? -1 : over_filling_};
        for (const HealthWarning<Dim>& w : warnings_) {
            all.insert(all.end(), {double(int(w.problem)), w.amount, double(w.step), w.time});
            all.insert(all.end(), w.x.begin(), w.x.end());
        }
        return all;
    }
    /// False: no run has stored this.
    bool restore(const std::vector<double>& all) {
        constexpr std::size_t words = 4 + Dim;
        if (all.size() < 3 || (all.size() - 3) % words != 0 || all.size() > 3 + 3 * words) return false;
        if (std::any_of(all.begin(), all.end(), [](double x) { return std::isnan(x); })) return false;
        moved_ = all[0], last_gain_ = all[1];
        if (all[2] >= 0) over_filling_ = all[2];
        warnings_.clear();
        for (std::size_t at = 3; at < all.size(); at += words) {
            if (all[at] != 0 && all[at] != 1 && all[at] != 2) return false;
            HealthWarning<Dim> w{HealthProblem(int(all[at])), all[at + 1], std::int64_t(all[at + 2]), all[at + 3], {}};
            std::copy_n(all.begin() + std::ptrdiff_t(at) + 4, Dim, w.x.begin());
            warnings_.push_back(w);
        }
        return true;
    }

  private:
    bool has(HealthProblem problem) const {
        return std::any_of(warnings_.begin(), warnings_.end(),
                           [&](const HealthWarning<Dim>& w) { return w.problem == problem; });
    }

    /// Of energy, over what was in motion; 0 where rounding of the sums may have made it.
    double gain_of(const TimeSeriesRow<Dim>& row, double start_strain, double rounding) {
        const Totals<Dim>& t = row.totals;
        const double moved = t.kinetic + std::abs(row.dissipated) + std::abs(t.strain - start_strain);
        if (moved > moved_) moved_ = moved;
        const double all = moved_ + std::abs(row.potential) + std::abs(t.strain);
        const bool judged = row.lost_particles == 0 && !row.falls_round && moved_ > 1e3 * rounding * all;
        return judged && moved_ > 0 ? std::max(0.0, -row.unaccounted / moved_) : 0;
    }

    double moved_ = 0;      ///< the most energy in motion, dissipated or stored since the start [J]
    double last_gain_ = 0;  ///< in the row before
    double over_filling_ = std::numeric_limits<double>::quiet_NaN();
    std::vector<HealthWarning<Dim>> warnings_;
    std::string lost_volume_;
};

}  // namespace moraine
