#pragma once
// One rank's part in the agreement of each step (engine/agreement.hpp), and the last one that was reached.

#include <utility>

#include "engine/agreement.hpp"
#include "engine/engine.hpp"

namespace moraine {

class StepAgreement {
  public:
    explicit StepAgreement(const Comm& comm) : reduction_(comm) {}

    /// This rank's part of the next one.
    Agreement& own() { return own_; }
    /// The last one.
    const Agreement& reached() const { return reached_; }

    /// What a signal handler or a wall clock asks for; travels with the next agreement (Agreement::stop).
    void ask(std::uint32_t what) { asked_ |= what; }
    bool asks() const { return asked_ != 0; }
    /// Whether this rank is writing an output meanwhile.
    void say_writing(bool writing) { writing_ = writing; }

    /// Of a step with this report; computing: time of this rank's computing since the run began [s].
    template <int Dim>
    void report(const StepReport<Dim>& step, double computing) {
        own_ = Agreement{};
        own_.signal = step.signal;
        own_.square_speed = step.square_speed;
        own_.moved = step.moved;
        own_.faults = step.faults;
        own_.in_guard_layer = step.in_guard_layer;
        own_.seconds = computing - computed_;
        computed_ = computing;
    }
    /// with_requests: what was asked for is told. Collective, as all below.
    void start(bool with_requests) {
        own_.writing = writing_ ? 1 : 0;
        own_.stop = with_requests ? std::exchange(asked_, 0) : 0;
        reduction_.start(own_);
    }
    const Agreement& finish() { return reached_ = reduction_.finish(); }
    /// Of what is known between steps; the last step's agreement stays.
    Agreement conclude() {
        reduction_.start(own_);
        return reduction_.finish();
    }

  private:
    AgreementReduction reduction_;
    Agreement own_, reached_;
    std::uint32_t asked_ = 0;
    bool writing_ = false;
    double computed_ = 0;  ///< computing time up to the last step [s]
};

}  // namespace moraine
