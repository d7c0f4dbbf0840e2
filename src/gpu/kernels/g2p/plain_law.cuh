#pragma once
// Laws as kernels see them: clay without rate effect and softening has kernels of its own, in which nothing asks for
// either. A branch per particle and the registers of what lies behind it cost 1.7 % of a step in single precision
// (docs/adr/0004-device-kernels.md).

#include <type_traits>
#include <utility>

#include "core/material/laws.hpp"
#include "core/scene_spec.hpp"

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

/// f(law): with the law of the material, as its kernels see it.
template <class Real, class F>
auto with_kernel_law(const MaterialSpec& material, F&& f) {
    return with_law<Real>(material.law, material.parameters.data(), [&](const auto& law) {
        using Law = std::decay_t<decltype(law)>;
        if constexpr (Undrained<Law>)
            if (!law.strength.depends_on_rate && !law.strength.softens) return f(Plain<Law>(law));
        return f(law);
    });
}

}  // namespace moraine::gpu
