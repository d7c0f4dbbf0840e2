#pragma once
// How long the tables of an epoch hold: a state, and two sums of the largest displacements of all steps [cells].
//
//   unbinned ---step---> clear <---step---> in_guard_layer        begin(), begin_made_ahead(): back to unbinned
//
// What the particles of step n reached is agreed on in step n + 1. While somebody is in the guard layer, or while
// nobody knows, the first sum grows; it is 0 where nobody is. Tables are used up when it exceeds `reach`: with less
// than one cell more in the last step and in the next it is below 3, so that all are still in blocks of the topology
// (blocks/guard_layer.hpp). The second sum tells how old what the next tables are made from is.
//
// The same on all ranks, because what it is told is. Knows no particle, and sends nothing.

#include <algorithm>

namespace moraine {

class EpochLifetime {
  public:
    enum class State {
        unbinned,        ///< nothing was binned yet by these tables
        clear,           ///< nobody was in the guard layer one step ago
        in_guard_layer,  ///< somebody was
    };

    static constexpr double reach = 1;  ///< [cells]
    /// The next tables were begun too early when particles may have moved this far since [cells]: they would be in
    /// their guard layer at once, and beyond 4 they would not be in their topology.
    static constexpr double stale = 1.25;

    /// Tables of what is occupied now are taken.
    void begin() { begin_after(0); }

    /// Those are taken that were made from what was occupied at begin_next(): where it begins, somebody may be as deep
    /// in the guard layer as he went beyond a cell since.
    void begin_made_ahead() { begin_after(std::max(0.0, since_next_ - 1)); }

    /// The next tables, or a repartition, are begun to be made from what is occupied now.
    void begin_next() { since_next_ = 0; }

    /// What a step's agreement told: whether somebody was in the guard layer, and the largest displacement [cells].
    void step(bool in_guard_layer, double moved) {
        const bool unknown = state_ == State::unbinned;
        state_ = in_guard_layer && !unknown ? State::in_guard_layer : State::clear;  // else it is told of other tables
        in_guard_layer_ = unknown || state_ == State::in_guard_layer ? in_guard_layer_ + moved : 0;
        since_next_ += moved;
    }

    State state() const { return state_; }
    bool is_used_up() const { return in_guard_layer_ > reach; }
    /// Whether it will be within so many cells more.
    bool ends_within(double cells) const { return in_guard_layer_ > 0 && in_guard_layer_ + cells > reach; }
    /// The first sum [cells].
    double in_guard_layer() const { return in_guard_layer_; }
    bool next_is_stale() const { return since_next_ >= stale; }
    /// Whether what was begun must be taken now.
    bool next_is_used_up() const { return since_next_ >= reach; }

  private:
    void begin_after(double in_guard_layer) {
        state_ = State::unbinned;
        in_guard_layer_ = in_guard_layer;
    }

    State state_ = State::unbinned;
    double in_guard_layer_ = 0;  ///< since somebody is there: up to the step before
    double since_next_ = 0;      ///< since begin_next()
};

}  // namespace moraine
