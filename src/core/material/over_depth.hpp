#pragma once
// Laws whose strength is a number of each particle: su of the undrained clays, cohesion of Drucker-Prager soil.
//
// The law is the one with a single number, asked with the particle's own; that is its last scalar, set at the start by
// the scene's profile (seeding/strength_profile.hpp) and then carried like any scalar: outputs, checkpoints, messages
// and hashes need nothing new. Laws of their own, not a branch in those with a number, because these then pay neither a
// column nor a load. A scene does not name them: it writes a table in place of the number.

#include "core/material/drucker_prager.hpp"
#include "core/material/tresca.hpp"
#include "core/material/von_mises.hpp"

namespace moraine {

/// Law: with of(strength [Pa]), the same law with that strength. Parameter: its position in Law::parameters.
template <class Law, int Parameter>
struct OverDepth : Law {
    using Uniform = Law;
    static constexpr int varying = Parameter;
    static constexpr int own = Law::history;  ///< its scalar
    static constexpr int history = own + 1;

    explicit OverDepth(const double* values) : Law(values) {}

    template <class Step, class State>
    MORAINE_HD void update(const Step& step, State& state) const {
        Law::of(state.history[own]).update(step, state);
    }

    template <class Step, class State>
    MORAINE_HD void after_trial(const Step& step, State& state) const {
        Law::of(state.history[own]).after_trial(step, state);
    }
};

template <class Real>
struct VonMisesOverDepth : OverDepth<VonMises<Real>, 2> {
    static constexpr const char* name = "von-mises over depth";
    static constexpr const char* history_names[] = {"plastic_shear_strain", "su"};
    using OverDepth<VonMises<Real>, 2>::OverDepth;
};

template <class Real>
struct TrescaOverDepth : OverDepth<Tresca<Real>, 2> {
    static constexpr const char* name = "tresca over depth";
    static constexpr DeviceBlocks device_blocks{.averaged = 4, .double_fused = 2};
    static constexpr const char* history_names[] = {"plastic_shear_strain", "su"};
    using OverDepth<Tresca<Real>, 2>::OverDepth;
};

template <class Real>
struct DruckerPragerOverDepth : OverDepth<DruckerPrager<Real>, 4> {
    static constexpr const char* name = "drucker-prager over depth";
    static constexpr const char* history_names[] = {"plastic_shear_strain", "gap", "cohesion"};
    using OverDepth<DruckerPrager<Real>, 4>::OverDepth;
};

}  // namespace moraine
