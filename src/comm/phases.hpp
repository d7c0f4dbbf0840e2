#pragma once
// Where the time of a rank goes, phase by phase. The records, the cost model, the benchmarks and the timeline of
// `--trace` read this one clock, and a profiler hears of it; the watchdog of a run asks it from a thread of its own
// where a rank is now.

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <optional>

#include "comm/timeline.hpp"

namespace moraine {

enum class Phase { p2g, nodes, g2p, halo, agree, migrate, balance, output };

/// Ranges of a profiler, which nest; without functions there is none.
struct Profiler {
    void (*push)(const char* name) = nullptr;
    void (*pop)() = nullptr;
};

class Phases {
  public:
    static constexpr std::size_t count = 8;
    static constexpr std::array<const char*, count> names = {"p2g",   "nodes",   "g2p",     "halo",
                                                             "agree", "migrate", "balance", "output"};

    /// Runs f and adds up its wall time, under a name of its own in timelines, or that of the phase.
    template <class F>
    void time(Phase phase, const SpanName& name, const F& f) {
        const auto start = std::chrono::steady_clock::now();
        const int around = now_.exchange(static_cast<int>(phase), std::memory_order_relaxed);
        if (profiler_.push) profiler_.push(name.text);
        f();
        if (profiler_.pop) profiler_.pop();
        now_.store(around, std::memory_order_relaxed);
        const auto end = std::chrono::steady_clock::now();
        seconds_[static_cast<std::size_t>(phase)] += std::chrono::duration<double>(end - start).count();
        if (timeline_) timeline_->add(name, static_cast<int>(phase), start, end);
    }
    template <class F>
    void time(Phase phase, const F& f) {
        time(phase, names[static_cast<std::size_t>(phase)], f);
    }

    /// Runs f as a span of no phase, which holds those of phases: a step, the start.
    template <class F>
    void group(const SpanName& name, const F& f) {
        const auto start = std::chrono::steady_clock::now();
        if (profiler_.push) profiler_.push(name.text);
        f();
        if (profiler_.pop) profiler_.pop();
        if (timeline_) timeline_->add(name, -1, start, std::chrono::steady_clock::now());
    }

    /// What ends up in a timeline, which must outlive its use; none: nothing is kept but sums.
    void record(Timeline* timeline) { timeline_ = timeline; }
    /// Who else hears when a span begins and ends.
    void tell(const Profiler& profiler) { profiler_ = profiler; }

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
    Timeline* timeline_ = nullptr;
    Profiler profiler_;
};

}  // namespace moraine
