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

Watchdog::Watchdog(int rank, double limit) : rank_(rank), limit_(limit) {
    try {
        thread_ = std::thread([this] { watch(); });
    } catch (const std::system_error& error) {
        throw MachineError(fmt::format(
            "rank {} has no thread for the watchdog ({}). Raise the limits on memory and processes (ulimit -v, -u)?",
            rank_, error.code().message()));
    }
}

Watchdog::~Watchdog() {
    {
        const std::lock_guard lock(mutex_);
        over_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void Watchdog::set_limit(double limit) {
    {
        const std::lock_guard lock(mutex_);
        limit_ = limit;
    }
    changed_.notify_all();
}

void Watchdog::look_at(const Phases* phases) {
    const std::lock_guard lock(mutex_);
    phases_ = phases;
}

/// False once the run is over or has another limit.
bool Watchdog::sleep(double seconds, double limit) {
    std::unique_lock lock(mutex_);
    return !changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return over_ || limit_ != limit; });
}

void Watchdog::watch() {
    std::unique_lock lock(mutex_);
    while (!over_) {
        const double limit = limit_;
        if (limit <= 0) {
            changed_.wait(lock, [&] { return over_ || limit_ != limit; });
            continue;
        }
        lock.unlock();
        watch(limit);
        lock.lock();
    }
}

/// As long as this is the limit.
void Watchdog::watch(double limit) {
    const double pause = std::min(limit / 10, 5.0);
    StallTimer timer(limit, 2 * pause, wall_clock());
    while (sleep(pause, limit)) {
        const std::optional<Phase> now = phase();
        const bool patient = patient_.load(std::memory_order_relaxed);
        const double share = patient || now == Phase::output || now == Phase::balance ? 0.1 : 1;
        if (timer.expired(wall_clock(), step_.load(std::memory_order_relaxed), share)) return end_job(limit, pause);
    }
}

std::optional<Phase> Watchdog::phase() {
    const std::lock_guard lock(mutex_);
    return phases_ ? phases_->now() : std::nullopt;
}

/// Where this rank is, in words.
std::string Watchdog::place() {
    if (const std::optional<Phase> now = phase())
        return fmt::format("in {}", Phases::names[static_cast<std::size_t>(*now)]);
    const std::lock_guard lock(mutex_);
    return phases_ ? "between phases" : "before its first phase";
}

/// Others see it within two pauses, and say where they are; who is lost does not.
void Watchdog::end_job(double limit, double pause) {
    fmt::print(stderr,
               "moraine: rank {}: no step was finished for {:g} s (it is {}, after step {}). Is a link or a host lost, "
               "or run.watchdog too short? The last checkpoint is whole.\n",
               rank_, limit, place(), step_.load(std::memory_order_relaxed));
    if (!sleep(3 * pause, limit)) return;
    std::signal(SIGALRM, leave);  // should the launcher be lost as well
    ::alarm(patience_of_mpi);
    MPI_Abort(MPI_COMM_WORLD, machine_failed);
}

}  // namespace moraine
