#pragma once
// The wave speeds of sleepers: dt counts them, though no gather tells of them. Asked once, when a block falls asleep or
// an epoch begins, because what sleeps keeps its stress.

#include <cuda_runtime_api.h>

#include <memory>

#include "core/scene_spec.hpp"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

/// The waves of one material. Not collective.
template <class Real, int Dim>
class WaveKernel {
  public:
    virtual ~WaveKernel() = default;
    /// wave[b] becomes the largest c of the block's particles [m/s], of own blocks that sleep; of the first material
    /// (mine = 0), or raised to that of another. material_of: by body; null: all are of this one.
    virtual void run(const View<Real, Dim>& view, const std::uint8_t* asleep, double* wave,
                     const std::uint16_t* material_of, int mine, cudaStream_t stream) const = 0;
};

template <class Real, int Dim>
std::unique_ptr<WaveKernel<Real, Dim>> make_waves(const MaterialSpec& material);

}  // namespace moraine::gpu
