#pragma once
// `moraine report`: hands over to the script beside the program (scripts/report, Python with matplotlib), which
// reads what runs wrote. Plots are a plotting library's work; what a run is and did stays in its files.

namespace moraine {

/// `argv` as main has it; before MPI starts. Does not return where the script can be started; else an exit code,
/// and the reason on stderr.
int become_report(int argc, char** argv);

}  // namespace moraine
