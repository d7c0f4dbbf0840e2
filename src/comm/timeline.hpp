#pragma once
// What one rank did when: spans, each behind the one before or inside it, in bounded memory; Phases records them.
//
// A span belongs to a step. When `capacity` spans are held, the stride doubles and steps that it does not divide are
// forgotten, so that a run of any length leaves whole steps from its start to its end (a ring would leave its end, a
// limit its start). Spans that are rare, as outputs, are kept whatever their step, as long as there is space.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace moraine {

using SteadyTime = std::chrono::steady_clock::time_point;

/// What a span is called; a literal, so that it needs no memory.
struct SpanName {
    constexpr SpanName(const char* literal, bool is_rare = false) : text(literal), rare(is_rare) {}
    const char* text;
    bool rare;  ///< kept in every step
};

/// Something that took time: begin and length since the timeline's start [ns].
struct Span {
    SpanName name;
    int phase = -1;  ///< as of Phases::names; -1: none
    std::int64_t begin = 0, length = 0;
    std::int64_t step = 0;
};

class Timeline {
  public:
    /// Holds at most so many spans, at least 16.
    explicit Timeline(std::size_t capacity);

    /// Time zero; what was before is forgotten.
    void start() {
        spans_.clear();
        start_ = std::chrono::steady_clock::now();
    }
    /// What is added from now on belongs to this step.
    void begin_step(std::int64_t step) { step_ = step; }
    void add(const SpanName& name, int phase, SteadyTime begin, SteadyTime end);

    /// Forgets steps until the stride is at least this one: ranks then have the same steps.
    void thin(std::int64_t stride);
    std::int64_t stride() const { return stride_; }
    /// Rare spans for which there was no space.
    std::int64_t lost() const { return lost_; }
    /// In order of their beginnings, those that hold others before these. Until the next one is added.
    const std::vector<Span>& sorted();

  private:
    bool is_kept(const Span& span) const { return span.name.rare || span.step % stride_ == 0; }

    std::size_t capacity_;
    SteadyTime start_{};
    std::int64_t step_ = 0, stride_ = 1, lost_ = 0;
    std::vector<Span> spans_;
};

}  // namespace moraine
