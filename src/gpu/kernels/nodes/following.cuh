#pragma once
// What of the soil follows a structure that turns (core/structures/contact_field.hpp), to its sums.

#include "core/structures/contact_field.hpp"
#include "gpu/kernels/account.cuh"

namespace moraine::gpu {

/// Structure k turns. Any lanes may call it.
template <int Dim>
__device__ __forceinline__ void tell_following(const ContactField<Dim>& field, int k, const Quantum& quantum,
                                               const Following<Dim>& by) {
    double values[TurningSums<Dim>::count];
    following_values(by, values);
    add_together(field.turning[k].sum, quantum, values);
}

}  // namespace moraine::gpu
