#pragma once
// Laws as kernels see them: what a mask says of a law over depth is a constant, and clay without rate effect and
// softening has kernels of its own, in which nothing asks for either. A branch per particle and the registers of what
// lies behind it cost 1.7 % of a step in single precision (docs/adr/0004-device-kernels.md).

#include "core/material/law_list.hpp"

namespace moraine::gpu {

/// A law over depth of one mask (over_depth.hpp): its scalars are in registers, and nothing asks which they are.
template <class Law, int Mask>
struct OfMask : Law {
    static constexpr int history = Law::own + bits_below(Mask, Law::strength_now + 1);

    template <class Step, class State>
    __device__ __forceinline__ void update(const Step& step, State& state) const {
        fixed().update(step, state);
    }
    template <class State>
    __device__ __forceinline__ auto wave_modulus(const State& state) const {
        return fixed().wave_modulus(state);
    }
    template <class State, class Real>
    __device__ __forceinline__ Real inverse_density(const State& state, Real of_material) const {
        return fixed().inverse_density(state, of_material);
    }

  private:
    __device__ __forceinline__ Law fixed() const {
        Law law = *this;
        law.mask = Mask;
        return law;
    }
};

/// The law of a clay that does neither; the same formulas.
template <Undrained Law>
struct Plain : Law {
    explicit Plain(const Law& law) : Law(law) {}

    template <class Step, class State>
    __device__ __forceinline__ void update(const Step& step, State& state) const {
        Law plain = *this;
        plain.strength.depends_on_rate = false;
        plain.strength.softens = false;
        plain.update(step, state);
    }
};

}  // namespace moraine::gpu
