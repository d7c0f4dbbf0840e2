#pragma once
// Where the time of a rank goes, phase by phase. The records, the cost model and the benchmarks read
// this one clock.

#include <array>
#include <chrono>
#include <cstddef>

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
        f();
        seconds_[static_cast<std::size_t>(phase)] +=
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }

    /// Adds up time that somebody else measured [s].
    void add(Phase phase, double seconds) { seconds_[static_cast<std::size_t>(phase)] += seconds; }

    double seconds(Phase phase) const { return seconds_[static_cast<std::size_t>(phase)]; }
    const std::array<double, count>& all() const { return seconds_; }

    /// Time spent computing, without waiting for others [s].
    double computing() const { return seconds(Phase::p2g) + seconds(Phase::nodes) + seconds(Phase::g2p); }

  private:
    std::array<double, count> seconds_{};
};

}  // namespace moraine
