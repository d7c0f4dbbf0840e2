#pragma once
// How long the steps of a scene take on a machine that was measured: the table behind the minutes of `moraine check`.
// A machine at hand is measured by `check --time` (app/step_timing.hpp).
//
// Medians of benchmarks/step/results.md (one core of an Intel Xeon, family 6, model 207, commit 0b1d4d0) and
// benchmarks/device/results.md (one NVIDIA H200, commits b9f211f and f50c8d4), 3-D, quadratic, FLIP, von Mises; affine
// transfers and ground take more. Between the sizes that were measured on the device a step's time is taken as linear
// in the particles.

#include "predict/prediction.hpp"

namespace moraine {

/// What a step of `substeps` costs on the host, in steps of particles' pressure (docs/adr/0009-grid-pressure.md).
double substep_cost(int substeps);

/// Of a step on one core, or on one device [s].
double step_seconds(const Scene& scene, const Prediction& prediction, bool on_device);

/// "12 min", "3.4 h", "1.2 days": seconds in words.
std::string duration_text(double seconds);

/// "about 12 min on one core of an Intel Xeon (...)": of all steps, without outputs, on `ranks` cores or devices that
/// share the work evenly.
std::string run_time_text(const Scene& scene, const Prediction& prediction, int ranks, bool on_devices);

}  // namespace moraine
