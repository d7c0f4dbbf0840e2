#pragma once
// Surfaces that act where they are, on the device (Bed::surface): what of them holds for an epoch, made by the host and
// copied (blocks/surface_plan.hpp), and the launches of a step.
//
// Gaps are found with the sums of a step's first round, into the tiles of gaps, and travel as those. Behind the nodes:
// which elements the soil touches and their W_i, once a step; then elements, and slaves, each a launch that gives to
// tiles and one that sums them at nodes. Where a structure moves the plan is made anew in each step.

#include "blocks/surface_plan.hpp"
#include "core/transfer/method.hpp"
#include "gpu/compile/kernel.hpp"
#include "gpu/contact_state.hpp"
#include "gpu/kernels/surfaces/surface_work.hpp"
#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
class SurfaceState {
  public:
    /// On the current device. cell: h [m].
    SurfaceState(const KernelKey& key, const Method<Host, Real, Dim>& method, double cell);

    void forget() { known_ = false; }
    /// The plan of this epoch, or of this step where a structure moves. Asynchronous.
    void begin(const StructureSet<Dim>& set, const EpochTables<Dim>& tables, cudaStream_t stream);
    /// Fills the gap tiles of these pairs. contact: on the device. Asynchronous.
    void find_gaps(const View<Real, Dim>& view, const ContactField<Dim>& contact, const DeviceGaps<Dim>& gaps,
                   const Array<ContactPair>& pairs, cudaStream_t stream) const;
    /// The nodes of a step are there: masses and W_i. Asynchronous, as the next.
    void begin_step(SurfaceWork<Real, Dim> work, cudaStream_t stream) const;
    /// Acts on velocities. damping: of the grid's pressure.
    void act(SurfaceWork<Real, Dim> work, double damping, cudaStream_t stream) const;

    /// Cells beside surfaces, where the pressure is the grid's: in a step, those that take part; before the nodes of
    /// each substep their forces, behind them what flows in; at its end what particles take.
    void find_cells(OpenWork<Real, Dim> work, const Substep& first, cudaStream_t stream) const;
    void press(OpenWork<Real, Dim> work, const Substep& substep, cudaStream_t stream) const;
    void find_fluxes(OpenWork<Real, Dim> work, cudaStream_t stream) const;
    void finish(OpenWork<Real, Dim> work, const Substep& last, cudaStream_t stream) const;

  private:
    void upload(const EpochTables<Dim>& tables, cudaStream_t stream);
    void upload_ring(cudaStream_t stream);
    void upload_cells(const std::vector<std::int32_t>& beds, cudaStream_t stream);
    SurfaceTables<Dim> tables() const;
    void complete(SurfaceWork<Real, Dim>& work, const SurfaceTiles<Real>& tiles) const;
    void complete(OpenWork<Real, Dim>& work) const;
    void advance(OpenWork<Real, Dim> work, const Substep& substep, bool presses, cudaStream_t stream) const;
    unsigned node_grid() const;
    bool has_cells() const { return method_.grid_bulk() != nullptr; }

    const Method<Host, Real, Dim>& method_;
    Kernel gaps_, weigh_, sum_, act_, close_, apply_;
    Kernel keep_held_, find_cells_, sum_pass_, close_cells_, fill_holes_, press_, hold_forces_, fluxes_;
    SurfacePlan<Dim> plan_;
    bool known_ = false;
    int givers_ = 0;
    PoolArray<std::int32_t> bed_of_, giver_of_, giver_, first_element_, first_slave_, near_nodes_, near_of_,
        first_ring_;
    PoolArray<SurfaceElement<Dim>> elements_;
    PoolArray<SlaveNode<Dim>> slaves_;
    PoolArray<RingElement<Dim>> ring_;
    PoolArray<std::uint16_t> around_;
    PoolArray<std::uint32_t> first_around_;
    PoolArray<Real> tiles_, shares_;
    PoolArray<std::int32_t> element_tiles_, slave_tiles_;  ///< by own block: who gives (SurfaceTiles)
    // Of the grid's pressure.
    PoolArray<CutCell<Dim>> cuts_;
    PoolArray<SurfaceCell<Dim>> places_;
    PoolArray<OpenNode> open_nodes_;
    PoolArray<OpenCell<Real, Dim>> cells_;
    PoolArray<Real> sums_;
    PoolArray<Vec<Real, Dim>> acceleration_;
    PoolArray<std::uint8_t> has_children_, has_roots_;
    PoolArray<std::int32_t> cell_tiles_;  ///< as element_tiles_
};

}  // namespace moraine::gpu
