#pragma once
// Absorbing ends (core/nodes/absorbing_ends.hpp): measured where they begin, at the start of a run or of a stage, and
// the same on all ranks from then on, whoever owns their nodes.

#include "comm/comm.hpp"
#include "engine/engine.hpp"
#include "simulation/run_clock.hpp"

namespace moraine {

/// Those that absorb from now on; measured: a checkpoint had them. Binned state only. Collective.
template <class Real, int Dim>
void begin_ends(const Scene& scene, const Comm& comm, bool measured, Engine<Real, Dim>& engine, RunClock<Dim>& clock);

}  // namespace moraine
