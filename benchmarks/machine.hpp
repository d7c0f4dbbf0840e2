#pragma once
// What a benchmark says about where it ran, and how it measures: machine, build, memory, spread.
//
// Numbers of two machines are never compared; those of one run are, as ratios. So every line that a
// benchmark prints carries the processor, the compiler and -march, and a median with its spread.

#include <cstdint>
#include <string>
#include <vector>

namespace moraine {

struct Machine {
    std::string processor;
    std::string cache;     ///< of the last level, shared
    int cores;             ///< that this process may use
    std::string compiler;  ///< with the flags that matter
    std::string march;
};

Machine this_machine();

/// Largest memory that this process ever had resident [bytes].
std::int64_t peak_memory();

/// Processor time of this process [s]: steadier than wall time where others compute too.
double processor_seconds();
double wall_seconds();

struct Spread {
    double median;
    double deviation;  ///< median distance from the median
};

/// `values` must not be empty.
Spread spread_of(std::vector<double> values);

/// The fields of a JSON object that name commit and machine, without braces.
std::string machine_json(const Machine& machine);

/// One sentence for a results page.
std::string machine_sentence(const Machine& machine);

}  // namespace moraine
