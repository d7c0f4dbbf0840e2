#pragma once
// The lock of a run directory: one run at a time writes into it.
//
// Rank 0 holds flock(2) on DIR/run.lock, which ends with the process: what a killed run leaves never blocks the next
// one. The file names host and process for those who wait. Where a file system has no flock, these words
// stand for it: a process of this host that lives holds the lock, anything else has left it behind.

#include <string>

namespace moraine {

class RunLock {
  public:
    RunLock() = default;
    /// Throws InputError if another run holds it. Not collective: for rank 0.
    explicit RunLock(const std::string& directory);
    ~RunLock();
    RunLock(RunLock&& other) noexcept;
    RunLock& operator=(RunLock&& other) noexcept;

    /// Throws InputError if a run holds the lock of this directory; leaves nothing behind.
    static void check_free(const std::string& directory);

  private:
    std::string path_;
    int handle_ = -1;  ///< -1: holds none
};

}  // namespace moraine
