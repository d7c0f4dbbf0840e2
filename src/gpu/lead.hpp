#pragma once
// A lead: steps that a device makes by itself (engine/lead_rule.hpp), as graphs of kernels, and the reports of each.
//
// Entry k of a lead holds the report of the step before its step k, and whether step k is made. The host reads an entry
// once its serial is there, and does not wait for the stream. Steps are queued a few ahead of the entries that the host
// has taken, because what is queued behind the end of a lead still runs, switched off; so entries are a ring.

#include "core/data/rank_failure.hpp"
#include "engine/engine.hpp"
#include "gpu/lead_graph.hpp"
#include "gpu/memory/stopwatch.hpp"

namespace moraine::gpu {

template <int Dim>
struct LeadEntries {
    LeadEntry<Dim> entry[lead_entries];
};

/// Steps that a device has before it.
inline constexpr int steps_ahead = 12;
static_assert(steps_ahead < lead_entries, "the entry that was taken last is still read");

template <class Real, int Dim>
class Lead {
  public:
    Lead() {
        entries_.host() = {};
        state_.resize(1);
    }

    using Key = std::vector<std::uint64_t>;
    LeadState<Dim>* state() const { return state_.data(); }
    /// Takes the graph of `key` if there is one: else it is to be captured, as the present one.
    bool take_graph(const Key& key) {
        if (graph_[1 - now_].holds(key)) now_ = 1 - now_;
        return graph_[now_].holds(key);
    }
    bool has_next_graph(const Key& key) const { return graph_[1 - now_].holds(key); }
    /// Captures a graph, the present one or the next: step(behind, stream) launches one step with these columns, as
    /// `launches` says. While it does captured_columns() are these.
    template <class F>
    void capture(bool next, Key key, const std::vector<LeadLaunch>& launches, const Columns<Real, Dim>& columns,
                 const F& step) {
        LeadGraph& graph = graph_[next ? 1 - now_ : now_];
        captured_columns_ = &columns;
        graph.capture(launches, capturing_, [&](const LeadNodes& behind) { step(behind, capturing_); });
        captured_columns_ = nullptr;
        graph.set_key(std::move(key));
    }
    const Columns<Real, Dim>* captured_columns() const { return captured_columns_; }

    /// Begins a lead of at most clock.steps steps, behind what `stream` has; they are made once queue() has launched
    /// them. scales: of its steps, but for dt.
    void begin(const LeadRule<Dim>& rule, const LeadClock<Dim>& clock, const StepScales<Dim>& scales,
               std::uint32_t tiles, cudaStream_t stream) {
        const LeadGraph& graph = graph_[now_];
        begin_lead(state(), {rule, clock, entries_.device()->entry, serial_, tiles}, graph.nodes(), graph.node_count(),
                   stream);
        scales_ = scales;
        most_ = static_cast<int>(clock.steps) + static_cast<int>(clock.steps) % LeadGraph::steps;
        queued_ = taken_ = 0;
    }
    const StepScales<Dim>& scales() const { return scales_; }
    /// Launches the present graph until steps_ahead steps are queued that were not taken. Whether that was the last
    /// launch.
    bool queue(cudaStream_t stream) {
        if (queued_ == most_) return false;
        for (; queued_ < most_ && queued_ - taken_ <= steps_ahead - LeadGraph::steps; queued_ += LeadGraph::steps)
            graph_[now_].launch(stream);
        return queued_ == most_;
    }
    /// It ends with what is queued.
    void queue_no_more() { most_ = queued_; }
    /// Entries that may still be taken.
    int to_come() const { return most_ - taken_; }
    /// The decision before all that is captured behind it.
    void decide_before(const ReportWork<Dim>& work, const LeadNodes& behind) {
        decide(work, state(), behind, static_cast<int>(sizeof(Real)), capturing_);
    }
    /// The decision on a stream of its own, concurrent with sum(), which needs no dt. Both are captured.
    template <class F>
    void decide_concurrently(const ReportWork<Dim>& work, const LeadNodes& behind, const F& sum) {
        before_.record(capturing_);
        deciding_.wait_for(before_);
        decide(work, state(), behind, static_cast<int>(sizeof(Real)), deciding_);
        sum();
        decided_.record(deciding_);
        capturing_.wait_for(decided_);
    }
    bool is_under_way() const { return most_ > 0; }
    bool is_used_up() const { return taken_ == most_; }
    int taken() const { return taken_; }
    void end() {
        serial_ += static_cast<std::uint32_t>(queued_);
        most_ = queued_ = taken_ = 0;
    }

    /// The next entry; waits for it.
    const LeadEntry<Dim>& next(cudaStream_t stream) const {
        const LeadEntry<Dim>& entry = entries_->entry[taken_ % lead_entries];
        const std::uint32_t serial = serial_ + static_cast<std::uint32_t>(taken_) + 1;
        const auto is_there = [&] { return __atomic_load_n(&entry.serial, __ATOMIC_ACQUIRE) == serial; };
        for (unsigned asked = 1; !is_there(); ++asked) {
            if (asked % 4096 != 0) continue;
            const cudaError_t state = cudaStreamQuery(stream);
            if (state == cudaErrorNotReady) continue;
            check(state, "A step on the device");
            if (!is_there()) throw RankFailure("A step on the device wrote no report. Is the device in order?");
        }
        return entry;
    }

    /// The parts' times of the step that the entry reports, by the device's clock and the shares that the stopwatch
    /// last found; zeros where the step before was not of a lead.
    using Seconds = Stopwatch::Seconds;
    Seconds seconds_until(const LeadEntry<Dim>& entry) const {
        const double all = last_clock_ > 0 ? 1e-9 * static_cast<double>(entry.clock - last_clock_) : 0;
        const double timed = timed_[0] + timed_[1] + timed_[2];
        Seconds parts{};
        for (std::size_t k = 0; k < parts.size() && timed > 0; ++k) parts[k] = all * timed_[k] / timed;
        return parts;
    }
    /// Takes the next entry: dt of the step that is made, and times of the one that `report` is of.
    void take_into(StepReport<Dim>& report, cudaStream_t stream) {
        const LeadEntry<Dim>& entry = next(stream);
        report.next_dt = entry.dt;
        if (report.seconds[0] == 0) report.seconds = seconds_until(entry);
        ++taken_;
        last_clock_ = entry.clock;
        if (entry.report.in_guard_layer) queue_no_more();
    }
    void note_timed(const Seconds& seconds) {
        if (seconds[0] > 0) timed_ = seconds;
    }
    /// The step under way is not of a lead.
    void forget_clock() { last_clock_ = 0; }

  private:
    Stream capturing_{Stream::Rank::apart_usual}, deciding_{Stream::Rank::apart_usual};
    Event before_, decided_;
    LeadGraph graph_[2];
    int now_ = 0;
    const Columns<Real, Dim>* captured_columns_ = nullptr;  ///< null: no graph is being captured
    StepScales<Dim> scales_{};
    Array<LeadState<Dim>> state_;
    Pinned<LeadEntries<Dim>> entries_;
    std::uint32_t serial_ = 0;               ///< of the last entry of the leads before
    int most_ = 0, queued_ = 0, taken_ = 0;  ///< steps: of the lead, launched, known to the host
    std::uint64_t last_clock_ = 0;           ///< of the entry taken last [ns]; 0: a step since was the host's
    Seconds timed_{};
};

}  // namespace moraine::gpu
