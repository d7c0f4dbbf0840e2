#pragma once
// The progress line of a run, on stderr: step, time, time to go, speed and imbalance.
//
// On a terminal one line, rewritten; in a log a line now and then. The wall time is given, so that
// tests need no clock. Nothing here communicates: rank 0 makes a Progress that speaks, others a silent one.

#include <cstdint>
#include <cstdio>
#include <string>

namespace moraine {

struct ProgressState {
    std::int64_t step = 0;
    double time = 0;            ///< simulated [s]
    double particle_steps = 0;  ///< since this run began, all ranks
    double imbalance = 1;       ///< max/mean of particles
};

class Progress {
  public:
    enum class Style { silent, lines, terminal };

    /// silent if asked or not on rank 0; terminal if stderr is one.
    static Style style_for(bool quiet, bool is_root);

    Progress(Style style, double start_time, double end_time, double wall_now, std::FILE* out = stderr);

    /// Say it if it is time for that. `wall_now` [s] counts from anywhere. Not collective.
    void report(const ProgressState& state, double wall_now);

    /// The last line, and the end of the rewritten one. Not collective.
    void finish(const ProgressState& state, double wall_now);

    /// Empty the rewritten line, so that a message can be printed. Not collective.
    void clear();

  private:
    bool due(double time, double wall_now) const;
    void say(const ProgressState& state, double wall_now);

    Style style_;
    double start_time_, end_time_;  ///< simulated [s]
    double start_wall_;             ///< [s]
    double said_time_, said_wall_;
    double said_particle_steps_ = 0;
    std::FILE* out_;
};

/// "step 1200  t 0.25 of 2 s (12 %)  ETA 0:01:10  2.51 M particle-steps/s  imbalance 1.03"
std::string progress_line(const ProgressState& state, double end_time, double eta, double particle_steps_per_s);

}  // namespace moraine
