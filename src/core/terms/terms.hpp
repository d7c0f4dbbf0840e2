#pragma once
// Physics as terms: what a gather does to a particle besides taking its velocity, its place and dL from the nodes.
//
// A term is a struct with the data of one physics and some hooks; a gather calls those of its terms in the order of
// their list (core/transfer/g2p.hpp; on devices gpu/kernels/g2p/terms_of.cuh):
//   at_block       before the particles of a block: what it needs of all its nodes
//   at_cell        before those of a cell
//   before_gather  a particle, before its sums (devices)
//   on_rate        its sums, before anything is made of them
//   before_stress  its dL, stress and ln J, before the law; what is to be tallied
//   after_cell     all dL of a cell at once, before the law (such a cell stays in one batch; host)
//   on_velocity    the velocity that moves it
// `hooks` of a term names those that it has. On the host one whose on() says no costs the question; what it keeps
// through a block is its State.

#include "core/data/vec.hpp"

namespace moraine {

enum TermHook : unsigned {
    hook_block = 1,
    hook_cell = 2,
    hook_gather = 4,
    hook_rate = 8,
    hook_stress = 16,
    hook_after_cell = 32,
    hook_velocity = 64
};

template <class One, class Case>
struct StateOf {};
template <class One, class Case>
requires requires {
    typename One::template State<Case>;
}
struct StateOf<One, Case> : One::template State<Case> {};

template <class... T>
struct Terms : T... {
    template <class Case>
    struct State : StateOf<T, Case>... {};

    template <class One>
    MORAINE_HD One& get() {
        return *this;
    }

    /// Calls f(term, its state) for each that has the hook and is on, in order. of: the gather.
    template <unsigned Hook, class Case>
    MORAINE_HD void each(const auto& of, State<Case>& state, const auto& f) const {
        (call<Hook, T, Case>(of, state, f), ...);
    }

    /// Whether one is on that has the hook.
    template <unsigned Hook>
    MORAINE_HD bool any(const auto& of) const {
        return (asks<Hook, T>(of) || ...);
    }

  private:
    template <unsigned Hook, class One>
    MORAINE_HD bool asks(const auto& of) const {
        return (One::hooks & Hook) != 0 && static_cast<const One&>(*this).on(of);
    }
    template <unsigned Hook, class One, class Case>
    MORAINE_HD void call(const auto& of, State<Case>& state, const auto& f) const {
        if constexpr ((One::hooks & Hook) != 0)
            if (asks<Hook, One>(of)) f(static_cast<const One&>(*this), static_cast<StateOf<One, Case>&>(state));
    }
};

}  // namespace moraine
