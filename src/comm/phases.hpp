#pragma once
// Where the time of a rank goes, phase by phase. The records, the cost model and the benchmarks read
// this one clock; the watchdog of a run asks it from a thread of its own where a rank is now.

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <optional>

namespace moraine {

enum class Phase { p2g, nodes, g2p, halo, agree, migrate, balance, output };

class Phases {
  public:
    static constexpr std::size_t count = 8;
    static constexpr std::array<const char*, count> names = {"p2g",   "nodes",   "g2p",     "halo",
                                                             "agree", "migrate", "balance", "output"};

    /// Runs f and adds up its wall time.
    template <class F>
    void time(Phase phase, const F& f) {
        const auto start = std::chrono::steady_clock::now();
        const int around = now_.exchange(static_cast<int>(phase), std::memory_order_relaxed);
        f();
        now_.store(around, std::memory_order_relaxed);
        seconds_[static_cast<std::size_t>(phase)] +=
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }

    /// Adds up time that somebody else measured [s].
    void add(Phase phase, double seconds) { seconds_[static_cast<std::size_t>(phase)] += seconds; }

    double seconds(Phase phase) const { return seconds_[static_cast<std::size_t>(phase)]; }
    const std::array<double, count>& all() const { return seconds_; }

    /// The phase under way, the innermost of several; none: between phases. From any thread.
    std::optional<Phase> now() const {
        const int phase = now_.load(std::memory_order_relaxed);
        return phase < 0 ? std::nullopt : std::optional(static_cast<Phase>(phase));
    }

    /// Time spent computing, without waiting for others [s].
    double computing() const { return seconds(Phase::p2g) + seconds(Phase::nodes) + seconds(Phase::g2p); }

  private:
    std::array<double, count> seconds_{};
    std::atomic<int> now_{-1};
};

}  // namespace moraine
