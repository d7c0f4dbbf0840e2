#pragma once
// The grid's pressure on the device (core/fluid/grid_pressure.hpp): cells of the chosen blocks, and nodes, for
// quadratic splines. Particles take the result in gathers of their own (gpu/kernels/g2p/fluid.cuh).
//
// A substep is two launches: cells take what the velocities of the substep before make of them, and nodes what the
// cells around them push with. Of whole cells that is a number, which nodes read in the order of offsets; what others
// push with is summed by block, and nodes read it of those that have such cells. What nodes take of cells that are not
// whole is found once a step and kept, d 3^d reals a cell: found anew in each substep from moments, 3^d reals, it took
// longer than to read (benchmarks/device/results.md). The order of all sums follows from the blocks alone.

#include "core/grid/shape.hpp"
#include "core/transfer/kernel_key.hpp"
#include "gpu/compile/kernel.hpp"
#include "gpu/kernels/nodes/nodes.hpp"
#include "gpu/kernels/pressure/pressure_work.hpp"
#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

/// What stays through the substeps of a step.
template <class Real, int Dim>
class PressureState {
  public:
    /// bulk: by body. at_nodes: velocities of substeps are those that nodes have, which surfaces act on.
    void start(const Real* bulk, std::size_t bodies, bool at_nodes);
    /// Capacity for an epoch.
    void resize(std::size_t tiles, std::size_t node_blocks, cudaStream_t stream);
    PressureView<Real, Dim> view() const;

  private:
    PoolArray<CellPressure<Real>> cell_;
    PoolArray<CutFactors<Real, Dim>> factors_;
    PoolArray<HeldNode<Real, Dim>> held_;
    PoolArray<Quad<Real>> velocity_;
    PoolArray<Real> whole_, cut_;
    PoolArray<std::uint8_t> has_cut_;
    PoolArray<CellBlock<Dim>> blocks_;
    PoolArray<std::uint32_t> counts_;
    std::size_t tiles_ = 0;
    Array<Real> bulk_;
    bool at_nodes_ = false;
};

/// The launches of a step and its substeps.
template <class Real, int Dim>
class Pressure {
  public:
    Pressure() = default;
    explicit Pressure(const KernelKey& key);

    /// Nodes from the sums of particles.
    void hold_nodes(const HoldWork<Real, Dim>& work, cudaStream_t stream) const;
    /// The lists of a step's blocks begin anew.
    void begin_lists(const PressureView<Real, Dim>& pressure, cudaStream_t stream) const;
    /// Cells of the chosen blocks, which are a part: 0 or 1. `blocks`: about how many there are.
    void find_pressures(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure,
                        const NodeCapacity<Real, Dim>& capacity, const Chosen& chosen, int part, int blocks,
                        const Substep& first, cudaStream_t stream) const;
    /// What the velocities of the substep before make of the cells of a part, and what they push with.
    void advance_pressures(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure, int part, int blocks,
                           const PressureTask<Real>& task, cudaStream_t stream) const;
    /// Nodes after a substep. contact: null where the scene has no structures.
    void solve_nodes(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure, const Stencil& stencil,
                     const NodeRound<Real, Dim>& round, const Substep& substep, const Quantum& quantum,
                     cudaStream_t stream, const NodeContact<Dim>* contact) const;

  private:
    Kernel find_, advance_whole_, advance_cut_;
    NodeKernel hold_, substep_;
};

}  // namespace moraine::gpu
