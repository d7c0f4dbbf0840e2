#pragma once
// What the kernel of tractions is told.

#include "core/particles/particle_state.hpp"
#include "core/particles/traction.hpp"

namespace moraine::gpu {

/// With what holds in a step.
template <class Real, int Dim>
struct LoadWork {
    Traction<Real, Dim> traction[most_tractions];
    Real factor[most_tractions];
    int count;
    bool sets;                    ///< in this round
    ParticleLoad<Real, Dim>* of;  ///< by list entry: slots may change before the gather
    std::uint8_t* loaded;         ///< by own block
};

}  // namespace moraine::gpu
