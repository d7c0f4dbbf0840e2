#pragma once
// The machine failed under one rank alone, such as a device in its step: the others cannot know, and would wait for
// that rank until the watchdog ends them. main ends the job at once, with exit code 4. A failure that all ranks have
// agreed on is a MachineError (core/data/error.hpp).

#include "core/data/error.hpp"

namespace moraine {

struct RankFailure : MachineError {
    using MachineError::MachineError;
};

}  // namespace moraine
