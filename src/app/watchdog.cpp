#include "app/watchdog.hpp"

#include <fmt/format.h>
#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <system_error>

#include "core/data/error.hpp"

namespace moraine {
namespace {

constexpr int machine_failed = 4;         // an exit code of main
constexpr unsigned patience_of_mpi = 20;  // [s]

double wall_clock() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

extern "C" void leave(int) {
    ::_exit(machine_failed);
}

}  // namespace

StallTimer::StallTimer(double limit, double longest_gap, double now)
    : limit_(limit), longest_gap_(longest_gap), before_(now) {}

bool StallTimer::expired(double now, std::int64_t step, double share) {
    const double counted = share * std::min(now - before_, longest_gap_);
    before_ = now;
    waited_ = step == step_ ? waited_ + counted : 0;
    step_ = step;
    return waited_ >= limit_;
}

Watchdog::Watchdog(double limit, int rank, const Phases& phases) : limit_(limit), rank_(rank), phases_(phases) {
    if (limit_ <= 0) return;
    try {
        thread_ = std::thread([this] { watch(); });
    } catch (const std::system_error& error) {
        throw MachineError(fmt::format(
            "rank {} has no thread for the watchdog ({}). Raise the limits on memory and processes (ulimit -v, -u)?",
            rank_, error.code().message()));
    }
}

Watchdog::~Watchdog() {
    if (!thread_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        over_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

/// False once the run is over.
bool Watchdog::sleep(double seconds) {
    std::unique_lock lock(mutex_);
    return !changed_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return over_; });
}

void Watchdog::watch() {
    const double pause = std::min(limit_ / 10, 5.0);
    StallTimer timer(limit_, 2 * pause, wall_clock());
    while (sleep(pause)) {
        const std::optional<Phase> phase = phases_.now();
        const bool patient = patient_.load(std::memory_order_relaxed);
        const double share = patient || phase == Phase::output || phase == Phase::balance ? 0.1 : 1;
        if (timer.expired(wall_clock(), step_.load(std::memory_order_relaxed), share)) return end_job(pause);
    }
}

/// Others see it within two pauses, and say where they are; who is lost does not.
void Watchdog::end_job(double pause) {
    const std::optional<Phase> phase = phases_.now();
    fmt::print(
        stderr,
        "moraine: rank {}: no step was finished for {:g} s (it is {}, after step {}). Is a link or a host lost, or "
        "run.watchdog too short? The last checkpoint is whole.\n",
        rank_, limit_, phase ? fmt::format("in {}", Phases::names[static_cast<std::size_t>(*phase)]) : "between phases",
        step_.load(std::memory_order_relaxed));
    if (!sleep(3 * pause)) return;
    std::signal(SIGALRM, leave);  // should the launcher be lost as well
    ::alarm(patience_of_mpi);
    MPI_Abort(MPI_COMM_WORLD, machine_failed);
}

}  // namespace moraine
