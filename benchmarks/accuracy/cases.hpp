#pragma once
// What benchmark_accuracy measures: the cases with their levels of cells, and the configurations that run them.
//
// B0 is the method paper's scheme: gimp, FLIP, USL, fixed dt = 0.3 h/c. All others take the same dt, so that at equal
// cells a difference is the scheme's; the last ones take twice that dt and more, which B0's stability limit (about 0.74
// h/c) hardly allows. "on cells" is what the shipped scenes of fluids take, for flows only. What a run needs of the
// simulation is compiled once per precision (measure.ipp); this header knows nothing of it.

#include <string>
#include <utility>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

struct Configuration {
    std::string name;  ///< shape TRANSFER UPDATE or shape FMPM(k), and @cfl where it is not 0.3
    Shape shape;
    Transfer transfer;
    StressUpdate update;
    double cfl;             ///< dt c / h
    int order = 1;          ///< of FMPM
    bool on_cells = false;  ///< pressures on cells in substeps, smoothed and shifted; the step by the program's rule
};

/// Norms of one run by name; the first is the error that the tables and plots are of.
using Norms = std::vector<std::pair<std::string, double>>;

struct Measured {
    Norms norms;
    double particles = 0, steps = 0, particle_steps = 0;
    double wall = 0, processor = 0;  ///< of the step loop [s]
};

enum class Problem { bar, column, manufactured, vortex, slurry, slurry_at_rest, current, dam_break };

struct AccuracyCase {
    std::string name;
    std::string message;  ///< what it is, and what the error is
    Problem problem;
    std::vector<int> cells;
    bool drifts = false;     ///< bar
    double amplitude = 0;    ///< manufactured [m]
    double jitter = 0;       ///< manufactured, fraction of the particle spacing
    bool long_runs = false;  ///< only configurations that is_for_long_runs() takes
};

const std::vector<Configuration>& configurations();
const std::vector<AccuracyCase>& accuracy_cases();

/// Whether a case with long runs takes it: B0, the program's default, the best of the others in one round, and what has
/// pressures on cells, which no other case takes.
bool is_for_long_runs(const Configuration& c);

/// Runout of SEED-1 at `slurry_time` with `slurry_reference` cells over its height, in double [m]; kept.
double finest_slurry(const Configuration& c);
inline constexpr int slurry_reference = 80;
inline constexpr double slurry_time = 2;  ///< [s]

/// Where the front of SEED-1 comes to rest [m]: the mean of three transfers at H0 / 200
/// (benchmarks/validation/slurry.md: 60.46, 60.57 and 60.61 m, pressures on cells in ten substeps). A volume-of-fluid
/// method has 60.08 to 61.13 m.
inline constexpr double slurry_rests_at = 60.55;
inline constexpr double slurry_rest_time = 30;  ///< [s]

/// One level, on one rank. Throws PhysicsError where the method fails.
template <class Real>
Measured measure(const AccuracyCase& problem, const Configuration& c, int cells);

}  // namespace moraine
