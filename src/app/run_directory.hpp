#pragma once
// The directory that a run writes into: one run each, never mixed and never silently lost.
//
// A directory holds a run if it has summary.json, history.csv, particles.vtkhdf, cells.vtkhdf or a checkpoint. Only
// files that a run makes are ever removed; what a killed run was still writing (*.partial) goes at any
// claim. It is checked before the work of starting (no side effect) and claimed after it, so a run that
// is refused leaves nothing behind.

#include <string>

#include "app/run_lock.hpp"
#include "comm/comm.hpp"

namespace moraine {

enum class RunClaim {
    fresh,      ///< refuse a directory that holds a run
    overwrite,  ///< remove the files of the run that it holds
    resume,     ///< go on with the run that it holds, or start there
};

/// "runs/<scene name>"; InputError where that would not be a directory in runs.
std::string default_run_directory(const std::string& scene_name);

/// Throws InputError on all ranks if the directory would be refused. Creates nothing. Collective.
void check_run_directory(const Comm& comm, const std::string& path, RunClaim claim);

/// Checks, then creates or empties it. InputError on all ranks, and nothing created, if it cannot be
/// written or another run writes into it. The lock is rank 0's, and holds as long as it lives. Collective.
RunLock claim_run_directory(const Comm& comm, const std::string& path, RunClaim claim);

}  // namespace moraine
