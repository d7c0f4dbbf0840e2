#pragma once
// Over-filling on the device (core/fluid/over_filling.hpp): tiles of volumes, which travel as those of masses do, and
// the share of them that is above capacity. For rows of history.csv, not for steps: plain loops, and no lane is kept.

#include <cuda_runtime_api.h>

#include "core/fluid/over_filling.hpp"
#include "core/grid/shape.hpp"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

/// Writes the tiles of the chosen blocks: sum_p w_ip V_p in the first lane, +0 in all others. `blocks`: about how many
/// there are. Each sum has the order of the block's list. Asynchronous.
template <class Real, int Dim>
void sum_volumes(const View<Real, Dim>& view, Shape shape, const Chosen& chosen, int blocks, cudaStream_t stream);

/// Adds to sums[0] and [1] what NodeVolumes::above and all are of the nodes that are counted here. Asynchronous.
template <class Real, int Dim>
void count_volumes(const View<Real, Dim>& view, const Stencil& stencil, const NodeCapacity<Real, Dim>& capacity,
                   double inverse_volume, ExactSum* sums, cudaStream_t stream);

}  // namespace moraine::gpu
