#pragma once
// Absorbing ends (core/nodes/absorbing_ends.hpp): measured where they begin, at the start of a run or of a stage, and
// the same on all ranks from then on, whoever owns their nodes.

#include <functional>

#include "comm/comm.hpp"
#include "engine/engine.hpp"
#include "simulation/run_clock.hpp"

namespace moraine {

/// Answers a query by sums of the host's, collective.
template <int Dim>
using MeasureEnds = std::function<void(EndQuery<Dim>&)>;

/// Those that absorb from now on; measure: empty where a checkpoint had them. Binned state only. Collective.
template <class Real, int Dim>
void begin_ends(const Scene& scene, const Comm& comm, const MeasureEnds<Dim>& measure, Engine<Real, Dim>& engine,
                RunClock<Dim>& clock);

}  // namespace moraine
