#include "gpu/kernels/pressure/pressure.hpp"

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/launch.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
void PressureState<Real, Dim>::start(const Real* bulk, std::size_t bodies) {
    bulk_.assign(bulk, bodies);
}

template <class Real, int Dim>
void PressureState<Real, Dim>::resize(std::size_t tiles, std::size_t node_blocks, cudaStream_t stream) {
    cell_.resize(tiles * Block<Dim>::cells, stream);
    moments_.resize(tiles * Block<Dim>::cells, stream);
    held_.resize(node_blocks * Block<Dim>::cells, stream);
}

template <class Real, int Dim>
PressureView<Real, Dim> PressureState<Real, Dim>::view() const {
    return {cell_.data(), moments_.data(), held_.data(), bulk_.data()};
}

template <class Real, int Dim>
Pressure<Real, Dim>::Pressure(const KernelKey& key) {
    const std::vector<Kernel>& kernels = KernelStore::instance().kernels(pressure_program(key));
    find_ = kernels[0], advance_ = kernels[1];
    hold_ = {kernels[2], key.structures ? kernels[3] : Kernel()};
    substep_ = key.structures ? NodeKernel{kernels[4], kernels[5]} : NodeKernel{kernels[3], Kernel()};
}

template <class Real, int Dim>
void Pressure<Real, Dim>::hold_nodes(const HoldWork<Real, Dim>& work, cudaStream_t stream) const {
    hold_(work.view.table.node_blocks, Block<Dim>::cells, work, work.contact.near.mark != nullptr, stream);
}

template <class Real, int Dim>
void Pressure<Real, Dim>::find_pressures(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure,
                                         const NodeCapacity<Real, Dim>& capacity, const Chosen& chosen, int blocks,
                                         const Substep& first, cudaStream_t stream) const {
    const FindWork<Real, Dim> work{view,
                                   {{view.context, view.table, view.grid, pressure.cell, pressure.held, nullptr},
                                    view.list,
                                    capacity,
                                    chosen.block,
                                    first.dt,
                                    first.damping()},
                                   pressure.moments,
                                   pressure.bulk};
    find_(team_grid<Dim>(blocks), stream, {work, chosen.count}, "Finding cells");
}

template <class Real, int Dim>
void Pressure<Real, Dim>::advance_pressures(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure,
                                            const Chosen& chosen, int blocks, const PressureTask<Real>& task,
                                            cudaStream_t stream) const {
    advance_(team_grid<Dim>(blocks), stream, {view, chosen, pressure, task}, "Advancing cells");
}

template <class Real, int Dim>
void Pressure<Real, Dim>::solve_nodes(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure,
                                      const Stencil& stencil, const NodeRound<Real, Dim>& round, const Quantum& quantum,
                                      cudaStream_t stream, const NodeContact<Dim>* contact) const {
    const SubstepWork<Real, Dim> work{
        {view, round, stencil.origin, quantum, {}, contact ? *contact : NodeContact<Dim>{}}, pressure};
    substep_(view.table.node_blocks, Block<Dim>::cells, work, contact != nullptr, stream);
}

#define MORAINE_PRESSURE(Real, Dim)          \
    template class PressureState<Real, Dim>; \
    template class Pressure<Real, Dim>;
MORAINE_PRESSURE(float, 2)
MORAINE_PRESSURE(float, 3)
MORAINE_PRESSURE(double, 2)
MORAINE_PRESSURE(double, 3)

}  // namespace moraine::gpu
