#pragma once
// Particle to grid on the device: one launcher for each dimension, precision and shape, with and without C.
//
// A launcher writes the whole tile of every chosen block, on `stream`, by `grid_blocks` >= 1 thread blocks: their
// number is speed, never the answer. Tiles are those of core/p2g.hpp but for rounding; device bits depend on nothing
// but the lists. Body forces are the host's alone.

#include <cuda_runtime_api.h>

#include "core/scene_choices.hpp"
#include "gpu/kernels/p2g/p2g_scale.hpp"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
using P2g = void (*)(const View<Real, Dim>&, const Chosen&, int grid_blocks, Real cell, cudaStream_t);

template <class Real, int Dim>
using P2gMean = void (*)(const View<Real, Dim>&, const Chosen&, int grid_blocks, MeanScale<Real>, cudaStream_t);

/// Thread blocks that have one item each when there are at most `blocks` chosen ones: the fastest, since the device
/// then hands out items as thread blocks end. One too many costs half a nanosecond.
template <int Dim>
constexpr int p2g_grid(int blocks) {
    return blocks < 1 ? 1 : (Dim == 2 ? (blocks + 3) / 4 : blocks);
}

/// The launcher of a scene, made ready on the current device. Throws MachineError.
template <class Real, int Dim>
P2g<Real, Dim> choose_p2g(Shape shape, bool affine);
template <class Real, int Dim>
P2gMean<Real, Dim> choose_p2g_mean(Shape shape, bool affine);

}  // namespace moraine::gpu
