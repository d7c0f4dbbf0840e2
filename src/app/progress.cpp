#include "app/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace moraine {

namespace {

std::string clock_text(double seconds) {
    if (!std::isfinite(seconds)) return "-";
    const auto s = static_cast<std::int64_t>(std::llround(std::max(0.0, seconds)));
    return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string speed_text(double per_s) {
    if (!std::isfinite(per_s)) return "-";
    if (per_s >= 1e9) return fmt::format("{:.3g} G", per_s / 1e9);
    if (per_s >= 1e6) return fmt::format("{:.3g} M", per_s / 1e6);
    return fmt::format("{:.3g} k", per_s / 1e3);
}

}  // namespace

std::string progress_line(const ProgressState& state, double end_time, double eta, double particle_steps_per_s) {
    const double percent = end_time > 0 ? std::min(100.0, 100 * state.time / end_time) : 100;
    return fmt::format("step {}  t {:.6g} of {:.6g} s ({:.0f} %)  ETA {}  {} particle-steps/s  imbalance {:.3f}",
                       state.step, state.time, end_time, std::floor(percent), clock_text(eta),
                       speed_text(particle_steps_per_s), state.imbalance);
}

Progress::Style Progress::style_for(bool quiet, bool is_root) {
    if (quiet || !is_root) return Style::silent;
    return ::isatty(STDERR_FILENO) ? Style::terminal : Style::lines;
}

Progress::Progress(Style style, double start_time, double end_time, double wall_now, std::FILE* out)
    : style_(style),
      start_time_(start_time),
      end_time_(end_time),
      start_wall_(wall_now),
      said_time_(start_time),
      said_wall_(wall_now),
      out_(out) {}

bool Progress::due(double time, double wall_now) const {
    const double wait = wall_now - said_wall_;
    if (style_ == Style::terminal) return wait >= 0.2;
    // A log of a long run stays short: a line per 5 % of the run, or a minute without one.
    return wait >= 5 && (time - said_time_ >= 0.05 * (end_time_ - start_time_) || wait >= 60);
}

void Progress::say(const ProgressState& state, double wall_now) {
    const double wall = wall_now - start_wall_;
    const double eta = (end_time_ - state.time) * wall / (state.time - start_time_);
    const double speed = (state.particle_steps - said_particle_steps_) / (wall_now - said_wall_);
    const std::string line = progress_line(state, end_time_, eta, speed);
    fmt::print(out_, "{}{}{}", style_ == Style::terminal ? "\r\x1b[K" : "", line,
               style_ == Style::terminal ? "" : "\n");
    std::fflush(out_);
    said_time_ = state.time;
    said_wall_ = wall_now;
    said_particle_steps_ = state.particle_steps;
}

void Progress::report(const ProgressState& state, double wall_now) {
    if (style_ != Style::silent && due(state.time, wall_now)) say(state, wall_now);
}

void Progress::finish(const ProgressState& state, double wall_now) {
    if (style_ == Style::silent) return;
    if (state.time > said_time_) say(state, wall_now);
    if (style_ == Style::terminal) fmt::print(out_, "\n");
    std::fflush(out_);
}

void Progress::clear() {
    if (style_ != Style::terminal) return;
    fmt::print(out_, "\r\x1b[K");
    std::fflush(out_);
}

}  // namespace moraine
