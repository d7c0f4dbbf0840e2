#pragma once
// Particle to grid on the device: one kernel for each dimension, precision and shape, with and without C, with and
// without a mean of the nodes.
//
// A launch writes the whole tile of every chosen block, on `stream`, by `grid_blocks` >= 1 thread blocks: their number
// is speed, never the answer. Tiles are those of core/transfer/p2g.hpp but for rounding; device bits depend on nothing
// but the lists. Body forces are the host's alone.

#include "core/transfer/kernel_key.hpp"
#include "gpu/compile/kernel.hpp"
#include "gpu/kernels/p2g/p2g_scale.hpp"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

/// Thread blocks that have one item each when there are at most `blocks` chosen ones: the fastest, since the device
/// then hands out items as thread blocks end. One too many costs half a nanosecond.
template <int Dim>
constexpr int p2g_grid(int blocks) {
    return blocks < 1 ? 1 : (Dim == 2 ? (blocks + 3) / 4 : blocks);
}

template <class Real, int Dim>
class P2g {
  public:
    P2g() = default;
    /// mean: in the force quad's last lane, for scenes whose fluids want it (core/data/grid_views.hpp). Compiles the
    /// kernel, or finds it. Throws MachineError.
    P2g(const KernelKey& key, bool mean);

    /// Of the scale nothing but the cell counts without a mean.
    void operator()(const View<Real, Dim>& view, const Chosen& chosen, int grid_blocks, const MeanScale<Real>& scale,
                    cudaStream_t stream) const;

  private:
    Kernel kernel_;
    bool mean_ = false;
};

}  // namespace moraine::gpu
