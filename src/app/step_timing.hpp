#pragma once
// `moraine check --time`: a second of steps of the scene, on the ranks and devices that would run it, and the minutes
// of the run that follow; then one output into the present folder, whose file is removed again, for the share of time
// that outputs will take. Nothing is left.
//
// The first step, in which tables are made and memory is touched for the first time, does not count. Later ones differ:
// a flow that spreads occupies more blocks, and one that speeds up takes more steps than the prediction says.

#include <string>

#include "app/device.hpp"

namespace moraine {

/// "about 12 min by 93 steps of 11 ms (1 rank of 2 threads on the host), without outputs", and a line of outputs where
/// the run `writes` them. Collective; throws what a run throws.
std::string time_steps(const Scene& scene, const Comm& comm, const DeviceChoice& device, bool writes);

}  // namespace moraine
