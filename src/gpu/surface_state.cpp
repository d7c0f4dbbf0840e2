#include "gpu/surface_state.hpp"

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

namespace {

constexpr int threads = 128;  ///< surface_threads (gpu/kernels/surfaces/surface_nodes.cuh)

}  // namespace

template <class Real, int Dim>
SurfaceState<Real, Dim>::SurfaceState(const KernelKey& key, const Method<Host, Real, Dim>& method, double cell)
    : method_(method), plan_(cell, method.stencil.origin, method.grid_bulk() != nullptr) {
    const std::vector<Kernel>& all = KernelStore::instance().kernels(surfaces_program(key));
    Kernel* const to[] = {&kernels_.gaps,     &kernels_.weigh,       &kernels_.sum,         &kernels_.act,
                          &kernels_.close,    &kernels_.apply,       &kernels_.keep_held,   &kernels_.find_cells,
                          &kernels_.sum_pass, &kernels_.weigh_cells, &kernels_.close_cells, &kernels_.fill_holes,
                          &kernels_.press,    &kernels_.hold_forces, &kernels_.fluxes};
    for (std::size_t k = 0; k < all.size(); ++k) *to[k] = all[k];
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::begin(const StructureSet<Dim>& set, const EpochTables<Dim>& tables,
                                    const TileRound<Real, Dim>& round, cudaStream_t stream) {
    round_ = round;
    const bool moves = set.any_moves();
    if (known_ && !moves) return;
    plan_.make(tables, set.field(), moves, method_.context.walls, method_.capacity);
    on_.assign(plan_, tables.own.size(), method_.grid_bulk() != nullptr, stream);
    known_ = true;
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::find_gaps(const View<Real, Dim>& view, const ContactState<Dim>& contact,
                                        const Array<ContactPair>& pairs, cudaStream_t stream) const {
    if (pairs.size() == 0) return;
    const SurfaceGapWork<Real, Dim> work{view,         contact.field,        on_.tables(),
                                         pairs.data(), contact.gaps.tiles(), contact.gaps.bounds()};
    kernels_.gaps(static_cast<unsigned>(pairs.size()), stream, {work}, "Finding gaps of elements");
}

template <class Real, int Dim>
SurfaceWork<Real, Dim> SurfaceState<Real, Dim>::work_of(const Share& share, std::int32_t* tile_of) const {
    SurfaceWork<Real, Dim> work{};
    work.view = share.view;
    work.field = share.contact.at_nodes.field;
    work.gaps = share.contact.gaps.view();
    work.tables = on_.tables();
    work.tiles = {on_.tiles(), tile_of};
    work.shares = on_.shares();
    work.origin = method_.stencil.origin;
    work.mass_cutoff = static_cast<Real>(share.step.mass_cutoff);
    work.quantum = share.step.quantum;
    return work;
}

/// A launch that gives to tiles, which then travel.
template <class Real, int Dim>
template <class Work>
void SurfaceState<Real, Dim>::give(const Kernel& kernel, const Work& work, cudaStream_t stream,
                                   const char* what) const {
    if (on_.givers() > 0) kernel(static_cast<unsigned>(on_.givers()), stream, {work}, what);
    round_.send({work.tiles.tile_of, work.tiles.tile, nullptr, nullptr}, work.tiles.tile_of, work.view.table.own,
                SurfacePlan<Dim>::side);
}

/// A launch of a thread per node near a surface.
template <class Real, int Dim>
template <class Work>
void SurfaceState<Real, Dim>::at_nodes(const Kernel& kernel, const Work& work, cudaStream_t stream,
                                       const char* what) const {
    constexpr int blocks = threads / Block<Dim>::cells;
    if (work.tables.near == 0) return;
    kernel(static_cast<unsigned>((work.tables.near + blocks - 1) / blocks), stream, {work}, what);
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::begin_step(const Share& share, cudaStream_t stream) const {
    const SurfaceWork<Real, Dim> work = work_of(share, on_.element_tiles());
    give(kernels_.weigh, work, stream, "Weighing elements");
    at_nodes(kernels_.sum, work, stream, "Summing shares of elements");
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::act(const Share& share, const ContactTime& time, double damping,
                                  cudaStream_t stream) const {
    if (is_idle()) return;
    SurfaceWork<Real, Dim> work = work_of(share, on_.element_tiles());
    const auto sweep = [&](const ContactTime& in) {
        work.time = in;
        give(kernels_.act, work, stream, "Acting on surfaces");
        at_nodes(kernels_.apply, work, stream, "Applying impulses of surfaces");
    };
    if (method_.grid_bulk()) work.cells = on_.cells(), work.damping = damping;
    sweep(time);
    if (!method_.grid_bulk()) sweep(time.second());
    if (!on_.has_slaves() && !round_.travels()) return;
    work.tiles.tile_of = on_.slave_tiles();
    give(kernels_.close, work, stream, "Closing slaves");
    at_nodes(kernels_.apply, work, stream, "Applying impulses of slaves");
}

template <class Real, int Dim>
OpenWork<Real, Dim> SurfaceState<Real, Dim>::open_work_of(const Share& share, const Substep& substep) const {
    OpenWork<Real, Dim> work{};
    static_cast<SurfaceWork<Real, Dim>&>(work) = work_of(share, on_.cell_tiles());
    work.pressure = share.pressure;
    work.open = on_.open_tables(method_, plan_.h);
    work.dt = substep.dt, work.damping = substep.damping();
    return work;
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::find_cells(const Share& share, const Substep& first, cudaStream_t stream) const {
    if (is_idle()) return;
    const OpenWork<Real, Dim> work = open_work_of(share, first);
    at_nodes(kernels_.keep_held, work, stream, "Keeping what nodes hold");
    give(kernels_.find_cells, work, stream, "Finding cells beside surfaces");
    at_nodes(kernels_.sum_pass, work, stream, "Summing what cells do to nodes");
    give(kernels_.weigh_cells, work, stream, "Weighing cells beside surfaces");
    at_nodes(kernels_.sum_pass, work, stream, "Summing children");
    give(kernels_.close_cells, work, stream, "Closing cells beside surfaces");
    at_nodes(kernels_.sum_pass, work, stream, "Summing cells beside holes");
    give(kernels_.fill_holes, work, stream, "Filling holes");
    at_nodes(kernels_.sum_pass, work, stream, "Summing roots");
}

/// Cells take what flowed in during the substep before; presses: and give their forces, else they are done.
template <class Real, int Dim>
void SurfaceState<Real, Dim>::advance(const Share& share, const Substep& substep, bool presses,
                                      cudaStream_t stream) const {
    if (is_idle()) return;
    OpenWork<Real, Dim> work = open_work_of(share, substep);
    work.half_time = 0.5 * (substep.number - 0.5) * substep.dt;
    work.takes_roots = substep.is_first(), work.updates = !substep.is_first(), work.presses = presses;
    if (presses) {
        give(kernels_.press, work, stream, "Advancing cells beside surfaces");
        at_nodes(kernels_.hold_forces, work, stream, "Summing forces of cells beside surfaces");
    } else if (on_.givers() > 0) {
        kernels_.press(static_cast<unsigned>(on_.givers()), stream, {work}, "Finishing cells beside surfaces");
    }
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::find_fluxes(const Share& share, cudaStream_t stream) const {
    if (is_idle()) return;
    const OpenWork<Real, Dim> work = open_work_of(share, {});
    give(kernels_.fluxes, work, stream, "Finding what flows into cells beside surfaces");
    at_nodes(kernels_.sum_pass, work, stream, "Summing fluxes");
}

template class SurfaceState<float, 2>;
template class SurfaceState<float, 3>;
template class SurfaceState<double, 2>;
template class SurfaceState<double, 3>;

}  // namespace moraine::gpu
