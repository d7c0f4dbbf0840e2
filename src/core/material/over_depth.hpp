#pragma once
// Laws of which some numbers are each particle's own: stiffness, strength, density.
//
// The law is the one with single numbers, asked with the particle's own; these are its last scalars, set at the start
// by the scene's profiles (seeding/property_profile.hpp) and then carried like any scalar: outputs, checkpoints,
// messages and hashes need nothing new. One struct a law, whatever varies: a mask says which numbers are scalars, in
// this order, and there is a name for each mask (laws.cpp), so that a scene keeps what it varies and no more. A law
// where nothing varies is another one, and pays neither a column nor a load. A scene does not name these laws: it
// writes a table in place of a number.
//
//   bits 0 to n - 1      the parameters Law::over_depth
//   bit n, density       rho0: V = m / rho0 exp(ln J), c^2 = M J / rho0 (core/particles/stress.hpp)
//   bit n + 1, strength  s_u of an undrained clay now, with rate effect and softening: what an interface that follows
//                        the soil bears (core/structures/particle_gaps.hpp)

#include <iterator>

#include "core/material/drucker_prager.hpp"
#include "core/material/linear_elastic.hpp"
#include "core/material/neo_hookean.hpp"
#include "core/material/tresca.hpp"
#include "core/material/von_mises.hpp"

namespace moraine {

/// Whether the law has an undrained strength, which may depend on rate and soften (undrained_strength.hpp).
template <class Law>
concept Undrained = requires(const Law& law) {
    law.strength.depends_on_rate;
    law.strength.softens;
};

template <class Real, template <class> class Of>
struct OverDepth : Of<Real> {
    using Uniform = Of<Real>;
    static constexpr int own = Uniform::history;  ///< the first of its scalars
    static constexpr int density = static_cast<int>(std::size(Uniform::over_depth)), strength_now = density + 1;
    static constexpr int masks = 1 << (Undrained<Uniform> ? strength_now + 1 : density + 1);
    static constexpr int history = own + density + 1 + (Undrained<Uniform> ? 1 : 0);  ///< at most

    int mask;

    /// Of the values of the law, whose stiffness is each particle's in units of 1 Pa; then the mask.
    explicit OverDepth(const double* values) : Uniform(Values(values).all), mask(mask_of(values)) {}

    /// That it has.
    MORAINE_HD int scalars() const { return own + bits_below(mask, strength_now + 1); }
    MORAINE_HD bool has_one_stiffness() const { return (mask & 1) == 0; }

    template <class State>
    MORAINE_HD Real inverse_density(const State& state, Real of_material) const {
        return mask >> density & 1 ? Real(1) / state.history[own + bits_below(mask, density)] : of_material;
    }

    template <class Step, class State>
    MORAINE_HD void update(const Step& step, State& state) const {
        const Uniform law = of_point(state);
        law.update(step, state);
        keep_strength(law, step, state);
    }

    template <class Step, class State>
    requires requires(const Uniform& law, const Step& step, State& state) { law.after_trial(step, state); }
    MORAINE_HD void after_trial(const Step& step, State& state) const {
        const Uniform law = of_point(state);
        law.after_trial(step, state);
        keep_strength(law, step, state);
    }

    template <class State>
    MORAINE_HD Real wave_modulus(const State& state) const {
        return of_point(state).wave_modulus(state);
    }

    template <class State>
    MORAINE_HD Real strain_energy(const State& state) const {
        return of_point(state).strain_energy(state);
    }

  private:
    static constexpr int parameter_count = static_cast<int>(std::size(Uniform::parameters));
    static_assert(Uniform::over_depth[0] == 0, "young is the first");

    struct Values {
        double all[parameter_count];

        explicit Values(const double* values) {
            for (int k = 0; k < parameter_count; ++k) all[k] = values[k];
            if (mask_of(values) & 1) all[0] = 1;
        }
    };

    static int mask_of(const double* values) { return static_cast<int>(values[parameter_count]); }

    template <class State>
    MORAINE_HD Uniform of_point(const State& state) const {
        return Uniform::of(OwnProperties<Real>{mask, state.history + own});
    }

    template <class Step, class State>
    MORAINE_HD void keep_strength(const Uniform& law, const Step& step, State& state) const {
        if constexpr (Undrained<Uniform>)
            if (mask >> strength_now & 1)
                state.history[own + bits_below(mask, strength_now)] =
                    law.strength.at(law.rate_in(step), state.history[0]);
    }
};

template <class Real>
using LinearElasticOverDepth = OverDepth<Real, LinearElastic>;
template <class Real>
using NeoHookeanOverDepth = OverDepth<Real, NeoHookean>;
template <class Real>
using VonMisesOverDepth = OverDepth<Real, VonMises>;
template <class Real>
using TrescaOverDepth = OverDepth<Real, Tresca>;
template <class Real>
using DruckerPragerOverDepth = OverDepth<Real, DruckerPrager>;

}  // namespace moraine
