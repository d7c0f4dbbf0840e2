#pragma once
// Signals that ask a run for a checkpoint and the end: SIGTERM, SIGINT (Ctrl-C) and SIGUSR1.
//
// They are caught from the moment on at which a run has a directory to write into. Before, and in all other commands,
// nobody would look, and the default action (the end) is what is wanted. They stay caught until the process ends: a
// launcher hands a signal to its ranks one by one, and the last may already have been told by the others.

namespace moraine {

/// From now on. Not collective.
void catch_stop_signals();

/// One came to this rank.
bool stop_requested();

}  // namespace moraine
