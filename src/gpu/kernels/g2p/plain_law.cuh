#pragma once
// Laws as kernels see them: clay without rate effect and softening has kernels of its own, in which nothing asks for
// either. A branch per particle and the registers of what lies behind it cost 1.7 % of a step in single precision
// (docs/adr/0004-device-kernels.md).

#include "core/material/law_list.hpp"

namespace moraine::gpu {

/// Whether the law has an undrained strength, which may depend on rate and soften (undrained_strength.hpp).
template <class Law>
concept Undrained = requires(const Law& law) {
    law.strength.depends_on_rate;
    law.strength.softens;
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
