#pragma once
// `moraine report`, `moraine picture` and `moraine converge`: hand over to the scripts beside the program
// (scripts/report; the others, by scripts/package, the Python package), which read what runs wrote, or start them.
// Plots are a plotting library's work; what a run is and did stays in its files.

namespace moraine {

/// Whether a command is the work of a script.
bool is_script(const char* command);

/// Becomes the script of the command argv[1]; `argv` as main has it; before MPI starts. Does not return where the
/// script can be started; else an exit code, and the reason on stderr.
int become_script(int argc, char** argv);

}  // namespace moraine
