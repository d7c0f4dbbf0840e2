#pragma once
// `moraine replay`: what recorded loads would have cost on other numbers of ranks, under other partitioners and
// triggers. Everything it says of them is a prediction, and is called so; what the run itself did is called measured.

#include "replay/replay_options.hpp"

namespace moraine {

/// Prints the table and writes its CSV. Throws InputError. Not collective: one rank alone.
void replay(const ReplayOptions& options);

}  // namespace moraine
