#include "gpu/surface_state.hpp"

#include <algorithm>

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

namespace {

constexpr int threads = 128;  ///< surface_threads (gpu/kernels/surfaces/surface_nodes.cuh)

/// Blocks near a surface that have elements, slaves or, if they are asked for, cells beside it.
template <int Dim>
std::vector<std::int32_t> givers_of(const SurfacePlan<Dim>& plan, bool cells) {
    std::vector<std::int32_t> beds;
    for (std::size_t k = 0; k < plan.blocks.size(); ++k) {
        const auto first = plan.place_of.begin() + static_cast<std::ptrdiff_t>(k * Block<Dim>::cells);
        const bool near = cells && std::any_of(first, first + Block<Dim>::cells,
                                               [](const SurfaceCell<Dim>& cell) { return cell.near; });
        if (near || !plan.elements[k].empty() || !plan.slaves[k].empty()) beds.push_back(static_cast<std::int32_t>(k));
    }
    return beds;
}

}  // namespace

template <class Real, int Dim>
SurfaceState<Real, Dim>::SurfaceState(const KernelKey& key, const Method<Host, Real, Dim>& method, double cell)
    : method_(method), plan_(cell, method.stencil.origin) {
    const std::vector<Kernel>& all = KernelStore::instance().kernels(surfaces_program(key));
    Kernel* const to[] = {&kernels_.gaps,        &kernels_.weigh,       &kernels_.sum,        &kernels_.act,
                          &kernels_.close,       &kernels_.apply,       &kernels_.keep_held,  &kernels_.find_cells,
                          &kernels_.sum_pass,    &kernels_.close_cells, &kernels_.fill_holes, &kernels_.press,
                          &kernels_.hold_forces, &kernels_.fluxes};
    for (std::size_t k = 0; k < all.size(); ++k) *to[k] = all[k];
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::begin(const StructureSet<Dim>& set, const EpochTables<Dim>& tables, cudaStream_t stream) {
    const bool moves = set.any_moves(), cells = method_.grid_bulk() != nullptr;
    if (known_ && !moves) return;
    const ContactField<Dim> field = set.field();
    plan_.geometry.begin(field, method_.context.walls, method_.capacity);
    if (moves) plan_.geometry.forget();
    plan_.make(tables, field);
    const std::vector<std::int32_t> beds = givers_of(plan_, cells);
    on_.assign(plan_, beds, tables.own.size(), stream);
    if (cells) cells_.assign(plan_, beds, tables.own.size(), stream);
    known_ = true;
}

template <class Real, int Dim>
unsigned SurfaceState<Real, Dim>::node_grid() const {
    constexpr std::size_t blocks = threads / Block<Dim>::cells;
    return static_cast<unsigned>((plan_.near_nodes.size() + blocks - 1) / blocks);
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
SurfaceWork<Real, Dim> SurfaceState<Real, Dim>::work_of(const Share& share, const std::int32_t* tile_of) const {
    SurfaceWork<Real, Dim> work{};
    work.view = share.view;
    work.field = share.contact.at_nodes.field;
    work.gaps = share.contact.gaps.view();
    work.tables = on_.tables();
    work.tiles = {on_.tiles(), const_cast<std::int32_t*>(tile_of)};
    work.shares = on_.shares();
    work.origin = method_.stencil.origin;
    work.mass_cutoff = static_cast<Real>(share.step.mass_cutoff);
    work.quantum = share.step.quantum;
    return work;
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::begin_step(const Share& share, cudaStream_t stream) const {
    const SurfaceWork<Real, Dim> work = work_of(share, on_.element_tiles());
    if (grid() > 0) kernels_.weigh(grid(), stream, {work}, "Weighing elements");
    if (node_grid() > 0) kernels_.sum(node_grid(), stream, {work}, "Summing shares of elements");
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::act(const Share& share, const ContactTime& time, double damping,
                                  cudaStream_t stream) const {
    if (grid() == 0) return;
    SurfaceWork<Real, Dim> work = work_of(share, on_.element_tiles());
    work.time = time;
    if (method_.grid_bulk()) work.cells = cells_.cells(), work.damping = damping;
    kernels_.act(grid(), stream, {work}, "Acting on surfaces");
    kernels_.apply(node_grid(), stream, {work}, "Applying impulses of surfaces");
    if (!on_.has_slaves()) return;
    work.tiles.tile_of = on_.slave_tiles();
    kernels_.close(grid(), stream, {work}, "Closing slaves");
    kernels_.apply(node_grid(), stream, {work}, "Applying impulses of slaves");
}

template <class Real, int Dim>
OpenWork<Real, Dim> SurfaceState<Real, Dim>::open_work_of(const Share& share, const Substep& substep) const {
    OpenWork<Real, Dim> work{};
    static_cast<SurfaceWork<Real, Dim>&>(work) = work_of(share, cells_.tile_of());
    work.pressure = share.pressure;
    work.open = cells_.tables(method_, plan_.h);
    work.dt = substep.dt, work.damping = substep.damping();
    return work;
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::find_cells(const Share& share, const Substep& first, cudaStream_t stream) const {
    if (grid() == 0) return;
    const OpenWork<Real, Dim> work = open_work_of(share, first);
    kernels_.keep_held(node_grid(), stream, {work}, "Keeping what nodes hold");
    kernels_.find_cells(grid(), stream, {work}, "Finding cells beside surfaces");
    kernels_.sum_pass(node_grid(), stream, {work}, "Summing children");
    kernels_.close_cells(grid(), stream, {work}, "Closing cells beside surfaces");
    kernels_.sum_pass(node_grid(), stream, {work}, "Summing cells beside holes");
    kernels_.fill_holes(grid(), stream, {work}, "Filling holes");
    kernels_.sum_pass(node_grid(), stream, {work}, "Summing roots");
}

/// Cells take what flowed in during the substep before; presses: and give their forces, else they are done.
template <class Real, int Dim>
void SurfaceState<Real, Dim>::advance(const Share& share, const Substep& substep, bool presses,
                                      cudaStream_t stream) const {
    if (grid() == 0) return;
    OpenWork<Real, Dim> work = open_work_of(share, substep);
    work.half_time = 0.5 * (substep.number - 0.5) * substep.dt;
    work.takes_roots = substep.is_first(), work.updates = !substep.is_first(), work.presses = presses;
    kernels_.press(grid(), stream, {work}, "Advancing cells beside surfaces");
    if (presses) kernels_.hold_forces(node_grid(), stream, {work}, "Summing forces of cells beside surfaces");
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::find_fluxes(const Share& share, cudaStream_t stream) const {
    if (grid() == 0) return;
    const OpenWork<Real, Dim> work = open_work_of(share, {});
    kernels_.fluxes(grid(), stream, {work}, "Finding what flows into cells beside surfaces");
    kernels_.sum_pass(node_grid(), stream, {work}, "Summing fluxes");
}

template class SurfaceState<float, 2>;
template class SurfaceState<float, 3>;
template class SurfaceState<double, 2>;
template class SurfaceState<double, 3>;

}  // namespace moraine::gpu
