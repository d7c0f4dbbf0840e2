#pragma once
// What the tests of all verification problems share: which studies to run, and how a figure is printed.

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cstdlib>
#include <string>

#include "verification/run.hpp"

namespace moraine::verification {

/// Ladders and durations that are too long for every build.
inline bool long_tests() {
    const char* set = std::getenv("MORAINE_LONG_TESTS");
    return set && std::string(set) == "1";
}

/// Prints a figure, once however many ranks there are.
inline void say(const std::string& figure) {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank == 0) MESSAGE(figure);
}

}  // namespace moraine::verification
