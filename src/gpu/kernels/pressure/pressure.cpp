#include "gpu/kernels/pressure/pressure.hpp"

#include <algorithm>
#include <cmath>

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/launch.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
void PressureState<Real, Dim>::start(const Real* bulk, std::size_t bodies, bool at_nodes) {
    bulk_.assign(bulk, bodies);
    at_nodes_ = at_nodes;
}

template <class Real, int Dim>
void PressureState<Real, Dim>::resize(std::size_t tiles, std::size_t node_blocks, cudaStream_t stream) {
    cell_.resize(tiles * Block<Dim>::cells, stream);
    factors_.resize(tiles, stream);
    held_.resize(node_blocks * Block<Dim>::cells, stream);
    if (!at_nodes_) velocity_.resize(node_blocks * Block<Dim>::cells, stream);
    whole_.resize(tiles * Block<Dim>::cells, stream);
    cut_.resize(tiles * Dim * pressure_tile<Dim>, stream);
    has_cut_.resize(tiles, stream);
    tiles_ = tiles;
    blocks_.resize(4 * tiles, stream);
    counts_.resize(4, stream);
}

template <class Real, int Dim>
PressureView<Real, Dim> PressureState<Real, Dim>::view() const {
    PressureView<Real, Dim> v{cell_.data(), factors_.data(), held_.data(), velocity_.data(), whole_.data(),
                              cut_.data(),  has_cut_.data(), {},           bulk_.data()};
    for (std::size_t k = 0; k < 4; ++k) v.blocks[k / 2][k % 2] = {blocks_.data() + k * tiles_, counts_.data() + k};
    return v;
}

template <class Real, int Dim>
Pressure<Real, Dim>::Pressure(const KernelKey& key) {
    const std::vector<Kernel>& kernels = KernelStore::instance().kernels(pressure_program(key));
    find_ = kernels[0], advance_whole_ = kernels[1], advance_cut_ = kernels[2];
    hold_ = {kernels[3], key.structures ? kernels[4] : Kernel()};
    substep_ = key.structures ? NodeKernel{kernels[5], kernels[6]} : NodeKernel{kernels[4], Kernel()};
}

template <class Real, int Dim>
void Pressure<Real, Dim>::hold_nodes(const HoldWork<Real, Dim>& work, cudaStream_t stream) const {
    hold_(work.view.table.node_blocks, Block<Dim>::cells, work, work.contact.near.mark != nullptr, stream);
}

template <class Real, int Dim>
void Pressure<Real, Dim>::begin_lists(const PressureView<Real, Dim>& pressure, cudaStream_t stream) const {
    check(cudaMemsetAsync(pressure.blocks[0][0].count, 0, 4 * sizeof(std::uint32_t), stream),
          "Emptying lists of cells");
}

template <class Real, int Dim>
void Pressure<Real, Dim>::find_pressures(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure,
                                         const NodeCapacity<Real, Dim>& capacity, const Chosen& chosen, int part,
                                         int blocks, const Substep& first, cudaStream_t stream) const {
    const FindWork<Real, Dim> work{view,
                                   {{view.context, view.table, view.grid, pressure.cell, pressure.held, nullptr},
                                    view.list,
                                    capacity,
                                    chosen.block,
                                    first.dt,
                                    first.damping()},
                                   pressure,
                                   {pressure.blocks[part][0], pressure.blocks[part][1]}};
    find_(team_grid<Dim>(blocks), stream, {work, chosen.count}, "Finding cells");
}

template <class Real, int Dim>
void Pressure<Real, Dim>::advance_pressures(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure,
                                            int part, int blocks, const PressureTask<Real>& task,
                                            cudaStream_t stream) const {
    constexpr int teams = Dim == 3 ? 1 : 8, most = 4 * 1056;
    const AdvanceWork<Real, Dim> work{view, pressure, {pressure.blocks[part][0], pressure.blocks[part][1]}, task};
    advance_whole_(static_cast<unsigned>(std::clamp(blocks / teams, 1, most)), stream, {work}, "Advancing whole cells");
    advance_cut_(static_cast<unsigned>(std::max(few_blocks(blocks), 1)), stream, {work}, "Advancing cut cells");
}

template <class Real, int Dim>
void Pressure<Real, Dim>::solve_nodes(const View<Real, Dim>& view, const PressureView<Real, Dim>& pressure,
                                      const Stencil& stencil, const NodeRound<Real, Dim>& round, const Substep& substep,
                                      const Quantum& quantum, cudaStream_t stream,
                                      const NodeContact<Dim>* contact) const {
    const SubstepWork<Real, Dim> work{
        {view, round, stencil.origin, quantum, {}, contact ? *contact : NodeContact<Dim>{}},
        pressure,
        static_cast<Real>(std::pow(double(view.context.inverse_cell), 1 - Dim)),
        substep.is_last()};
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
