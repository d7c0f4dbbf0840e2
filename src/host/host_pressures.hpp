#pragma once
// The grid's pressure on the host, and its substeps (core/fluid/grid_pressure.hpp): pressures of cells, and what nodes
// hold from the sums of a step to its last substep. Not collective.

#include <array>
#include <span>

#include "blocks/patch.hpp"
#include "core/data/host.hpp"
#include "core/fluid/pressure_kernels.hpp"
#include "core/transfer/method.hpp"

namespace moraine {

template <class Real, int Dim>
class HostPressures {
  public:
    /// Both must outlive it.
    HostPressures(const Method<Host, Real, Dim>& method, Patch<Host, Real, Dim>& patch);

    /// Nodes hold what they sum from now on.
    void hold() { held_.resize(patch_.stored_nodes()); }
    void find(const Substep& first);
    /// Adds the forces of the cells of `blocks` to their tiles.
    void sum(std::span<const std::int32_t> blocks, const Substep& substep);
    void update(const Substep& substep);

    HeldNode<Real, Dim>* held() { return held_.data(); }
    const HeldNode<Real, Dim>* held() const { return held_.data(); }
    CellPressure<Real>* cells() { return cells_.data(); }
    const CellPressure<Real>* cells() const { return cells_.data(); }
    PressureContext<Real, Dim> context();
    KeptFactors<Real, Dim> factors() { return {factors_.data()}; }
    /// Memory for the cells of this step.
    void size_cells();

  private:
    const Method<Host, Real, Dim>& method_;
    Patch<Host, Real, Dim>& patch_;
    Host::Array<HeldNode<Real, Dim>> held_;
    Host::Array<CellPressure<Real>> cells_;
    Host::Array<CellNode<Real, Dim>> factors_;
    std::array<CellNode<Real, Dim>, PressureContext<Real, Dim>::nodes> whole_cell_;
};

}  // namespace moraine
