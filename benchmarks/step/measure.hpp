#pragma once
// Runs one case and measures its steps. Runs are stretches of consecutive steps of one simulation.

#include <array>
#include <string>

#include "comm/phases.hpp"
#include "machine.hpp"
#include "step/scenes.hpp"

namespace moraine {

struct Runs {
    int runs = 5;
    int steps = 20;   ///< of each run
    int warm_up = 5;  ///< steps before the first run
};

struct Measured {
    double particles = 0;
    double cells = 0;                            ///< occupied
    double blocks = 0;                           ///< occupied
    Spread wall{};                               ///< of a run [s]
    Spread processor{};                          ///< of a run [s]
    std::array<double, Phases::count> phases{};  ///< seconds per step, mean over all runs
    double step_seconds = 0;                     ///< wall, mean over all runs
    double moved = 0;                            ///< mean displacement of a particle per step [cells]
    double yielded = 0;                          ///< share of the particles with plastic strain; 0 without history
    double row_bytes = 0;                        ///< of one particle in all its columns
    std::int64_t seeded_bytes = 0;               ///< largest resident memory up to the first step
    std::int64_t peak_bytes = 0;                 ///< and to the last

    double rate(const Spread& s, const Runs& plan) const { return particles * plan.steps / s.median; }
};

/// Collective over one rank: MPI must be up.
Measured measure(const Case& c, const Runs& plan);

}  // namespace moraine
