#pragma once
// The grid's pressure on the device (core/fluid/grid_pressure.hpp): cells of the chosen blocks, and nodes, for
// quadratic splines. Particles take the result in gathers of their own (gpu/kernels/g2p/fluid.cuh).
//
// A substep is two launches: cells take what the velocities of the substep before make of them and give their nodes
// what they push with; nodes sum that over the tiles around them. The geometry of cells that are not whole stays as
// moments, 3^d reals, and what a node takes from it is found anew, axis by axis, for 16 cells at a time: a quarter of
// the bytes of its factors. The order of all sums follows from the blocks alone.

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
    /// bulk: by body.
    void start(const Real* bulk, std::size_t bodies);
    /// Capacity for an epoch.
    void resize(std::size_t tiles, std::size_t node_blocks, cudaStream_t stream);
    PressureView<Real, Dim> view() const;

  private:
    PoolArray<CellPressure<Real>> cell_;
    PoolArray<CellMoments<Real, Dim>> moments_;
    PoolArray<HeldNode<Real, Dim>> held_;
    Array<Real> bulk_;
};

/// The launches of a step and its substeps.
template <class Real, int Dim>
class Pressure {
  public:
    Pressure() = default;
    explicit Pressure(const KernelKey& key);

    /// Nodes from the sums of particles.
    void hold_nodes(const HoldWork<Real, Dim>& work, cudaStream_t stream) const;
    /// Cells of the chosen blocks. `blocks`: about how many there are.
    void find_pressures(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure,
                        const NodeCapacity<Real, Dim>& capacity, const Chosen& chosen, int blocks, const Substep& first,
                        cudaStream_t stream) const;
    /// What the velocities of the substep before make of them, and what they push with.
    void advance_pressures(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure, const Chosen& chosen,
                           int blocks, const PressureTask<Real>& task, cudaStream_t stream) const;
    /// Nodes after a substep. contact: null where the scene has no structures.
    void solve_nodes(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure, const Stencil& stencil,
                     const NodeRound<Real, Dim>& round, const Quantum& quantum, cudaStream_t stream,
                     const NodeContact<Dim>* contact) const;

  private:
    Kernel find_, advance_;
    NodeKernel hold_, substep_;
};

}  // namespace moraine::gpu
