#pragma once
// Surfaces that act where they are, on the device (Bed::surface): what of them holds for an epoch, made by the host and
// copied (blocks/surface_plan.hpp), and the launches of a step.
//
// Gaps are found with the sums of a step's first round, into the tiles of gaps, and travel as those. Behind the nodes:
// which elements the soil touches and their W_i, once a step; then elements, and slaves, each a launch that gives to
// tiles and one that sums them at nodes. Where a structure moves the plan is made anew in each step. Between ranks
// those tiles travel as the halo's, in each pass; all ranks make the same passes.

#include "engine/engine.hpp"
#include "gpu/compile/kernel.hpp"
#include "gpu/contact_state.hpp"
#include "gpu/exchange/tile_round.hpp"
#include "gpu/fluid_state.hpp"
#include "gpu/surface_tables.hpp"

namespace moraine::gpu {

/// Kernels of elements, and with the grid's pressure of cells (gpu/kernels/programs.hpp: surfaces_program).
struct SurfaceKernels {
    Kernel gaps, weigh, sum, act, close, apply;
    Kernel keep_held, find_cells, sum_pass, weigh_cells, close_cells, fill_holes, press, hold_forces, fluxes;
};

/// The share as surfaces see it in a step.
template <class Real, int Dim>
struct SurfaceShare {
    View<Real, Dim> view;
    const ContactState<Dim>& contact;
    const StepScales<Dim>& step;
    PressureView<Real, Dim> pressure;
};

template <class Real, int Dim>
class SurfaceState {
  public:
    using Share = SurfaceShare<Real, Dim>;

    /// On the current device. cell: h [m].
    SurfaceState(const KernelKey& key, const Method<Host, Real, Dim>& method, double cell);

    void forget() { known_ = false; }
    /// The plan of this epoch, or of this step where a structure moves; round: how tiles travel in this step.
    /// Asynchronous, as all that follows.
    void begin(const StructureSet<Dim>& set, const EpochTables<Dim>& tables, const TileRound<Real, Dim>& round,
               cudaStream_t stream);
    /// Until the event is over: finds what a flow may come to.
    void prefetch(const Event& until) {
        while (known_ && !until.is_over() && plan_.prefetch()) continue;
    }
    /// What nodes find.
    SurfaceSpace space() const { return {on_.tables().near_of, on_.nodes()}; }
    /// By node block: not negative where a surface is near; and 1 there.
    const std::int32_t* near_of() const { return on_.tables().near_of; }
    const std::uint8_t* near_mark() const { return on_.near_mark(); }
    /// Fills the gap tiles of these pairs.
    void find_gaps(const View<Real, Dim>& view, const ContactState<Dim>& contact, const Array<ContactPair>& pairs,
                   cudaStream_t stream) const;
    /// The nodes of a step are there: masses and W_i.
    void begin_step(const Share& share, cudaStream_t stream) const;
    /// Acts on velocities. damping: of the grid's pressure.
    void act(const Share& share, const ContactTime& time, double damping, cudaStream_t stream) const;

    /// Cells beside surfaces, where the pressure is the grid's: in a step, those that take part; before the nodes of
    /// each substep their forces, behind them what flows in; at its end what particles take.
    void find_cells(const Share& share, const Substep& first, cudaStream_t stream) const;
    void press(const Share& share, const Substep& substep, cudaStream_t stream) const {
        advance(share, substep, true, stream);
    }
    void find_fluxes(const Share& share, cudaStream_t stream) const;
    void finish(const Share& share, const Substep& last, cudaStream_t stream) const {
        advance(share, {last.number + 1, last.count, last.dt}, false, stream);
    }

  private:
    SurfaceWork<Real, Dim> work_of(const Share& share, std::int32_t* tile_of) const;
    OpenWork<Real, Dim> open_work_of(const Share& share, const Substep& substep) const;
    void advance(const Share& share, const Substep& substep, bool presses, cudaStream_t stream) const;
    template <class Work>
    void give(const Kernel& kernel, const Work& work, cudaStream_t stream, const char* what) const;
    template <class Work>
    void at_nodes(const Kernel& kernel, const Work& work, cudaStream_t stream, const char* what) const;
    bool is_idle() const { return on_.givers() == 0 && !round_.travels(); }

    const Method<Host, Real, Dim>& method_;
    SurfaceKernels kernels_;
    SurfacePlan<Dim> plan_;
    bool known_ = false;
    TileRound<Real, Dim> round_;
    DeviceSurfaces<Real, Dim> on_;
};

}  // namespace moraine::gpu
