#pragma once
// What can go wrong, by who can mend it; main turns each into an exit code.
//
// Messages read `problem (why). suggestion?`. A collective error is thrown with the same words on
// every rank, and printed once.

#include <stdexcept>
#include <string>

namespace moraine {

/// The input is wrong: exit code 2. Thrown before the first step.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The physics went wrong (NaN, J <= 0, a particle left a closed domain): exit code 3.
struct PhysicsError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The machine failed (MPI, CUDA, disk): exit code 4.
struct MachineError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A signal asked for the end, and a checkpoint was written: exit code 5.
struct Stopped : std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace moraine
