#pragma once
// The wave speeds of sleepers: dt counts them, though no gather tells of them. Asked once, when a block falls asleep or
// an epoch begins, because what sleeps keeps its stress.

#include <cstdint>

#include "gpu/kernels/g2p/g2p.hpp"

namespace moraine::gpu {

/// The waves of one material. Not collective.
template <class Real, int Dim>
class WaveKernel {
  public:
    WaveKernel(const KernelKey& key, const MaterialSpec& material, std::size_t number);
    /// wave[b] becomes the largest c of the block's particles [m/s], of own blocks that sleep; of the first material
    /// (mine = 0), or raised to that of another. material_of: by body; null: all are of this one.
    void run(const View<Real, Dim>& view, const std::uint8_t* asleep, double* wave, const std::uint16_t* material_of,
             int mine, cudaStream_t stream) const;

  private:
    Kernel kernel_;
    LawValue law_;
};

}  // namespace moraine::gpu
