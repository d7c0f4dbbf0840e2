#include "gpu/surface_state.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

namespace {

constexpr int threads = 128;  ///< surface_threads (gpu/kernels/surfaces/surface_nodes.cuh)

template <int Dim>
bool has_near_cell(const SurfacePlan<Dim>& plan, std::size_t k) {
    const auto first = plan.place_of.begin() + static_cast<std::ptrdiff_t>(k * Block<Dim>::cells);
    return std::any_of(first, first + Block<Dim>::cells, [](const SurfaceCell<Dim>& cell) { return cell.near; });
}

template <int Dim>
constexpr std::size_t tile_reals = std::size_t(SurfacePlan<Dim>::tile_nodes) * node_reals;

}  // namespace

template <class Real, int Dim>
SurfaceState<Real, Dim>::SurfaceState(const KernelKey& key, const Method<Host, Real, Dim>& method, double cell)
    : method_(method), plan_(cell, method.stencil.origin) {
    const std::vector<Kernel>& kernels = KernelStore::instance().kernels(surfaces_program(key));
    gaps_ = kernels[0], weigh_ = kernels[1], sum_ = kernels[2];
    act_ = kernels[3], close_ = kernels[4], apply_ = kernels[5];
    if (!has_cells()) return;
    keep_held_ = kernels[6], find_cells_ = kernels[7], sum_pass_ = kernels[8], close_cells_ = kernels[9];
    fill_holes_ = kernels[10], press_ = kernels[11], hold_forces_ = kernels[12], fluxes_ = kernels[13];
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::begin(const StructureSet<Dim>& set, const EpochTables<Dim>& tables, cudaStream_t stream) {
    const bool moves = set.any_moves();
    if (known_ && !moves) return;
    const ContactField<Dim> field = set.field();
    plan_.geometry.begin(field, method_.context.walls, method_.capacity);
    if (moves) plan_.geometry.forget();
    plan_.make(tables, field);
    upload(tables, stream);
    known_ = true;
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::upload(const EpochTables<Dim>& tables, cudaStream_t stream) {
    std::vector<std::int32_t> giver, beds, first_element{0}, first_slave{0};
    std::vector<std::int32_t> giver_of(tables.own.size(), -1);
    std::vector<SurfaceElement<Dim>> elements;
    std::vector<SlaveNode<Dim>> slaves;
    for (std::size_t k = 0; k < plan_.blocks.size(); ++k) {
        if (plan_.elements[k].empty() && plan_.slaves[k].empty() && !(has_cells() && has_near_cell(plan_, k))) continue;
        beds.push_back(static_cast<std::int32_t>(k));
        giver_of[static_cast<std::size_t>(plan_.blocks[k])] = static_cast<std::int32_t>(giver.size());
        giver.push_back(plan_.blocks[k]);
        elements.insert(elements.end(), plan_.elements[k].begin(), plan_.elements[k].end());
        for (const Slave& s : plan_.slaves[k]) {
            const std::int32_t near = plan_.node_at(static_cast<int>(k), s.own);
            slaves.push_back({s, plan_.surface_nodes[static_cast<std::size_t>(near)]});
        }
        first_element.push_back(static_cast<std::int32_t>(elements.size()));
        first_slave.push_back(static_cast<std::int32_t>(slaves.size()));
    }
    givers_ = static_cast<int>(giver.size());
    giver_.assign(giver, stream), giver_of_.assign(giver_of, stream);
    first_element_.assign(first_element, stream), first_slave_.assign(first_slave, stream);
    elements_.assign(elements, stream), slaves_.assign(slaves, stream);
    bed_of_.assign(plan_.bed_of, stream);
    near_nodes_.assign(plan_.near_nodes, stream), near_of_.assign(plan_.near_of, stream);
    tiles_.resize(giver.size() * tile_reals<Dim>, stream);
    shares_.resize(plan_.near_nodes.size() * Block<Dim>::cells * node_reals, stream);
    const std::vector<std::int32_t> nobody(tables.own.size() + tables.ghost.size(), -1);
    element_tiles_.assign(nobody, stream), slave_tiles_.assign(nobody, stream);
    upload_ring(stream);
    if (has_cells()) cell_tiles_.assign(nobody, stream), upload_cells(beds, stream);
}

/// beds: the givers' numbers among blocks near a surface.
template <class Real, int Dim>
void SurfaceState<Real, Dim>::upload_cells(const std::vector<std::int32_t>& beds, cudaStream_t stream) {
    constexpr std::size_t cells = Block<Dim>::cells;
    std::vector<SurfaceCell<Dim>> places;
    for (const std::int32_t k : beds)
        for (std::size_t c = 0; c < cells; ++c)
            places.push_back(plan_.place_of[static_cast<std::size_t>(k) * cells + c]);
    std::unordered_map<const CutCell<Dim>*, std::size_t> at;
    std::vector<CutCell<Dim>> cuts;
    const auto add = [&](const CutCell<Dim>* cut) {
        if (cut && at.emplace(cut, cuts.size()).second) cuts.push_back(*cut);
    };
    for (const SurfaceCell<Dim>& place : places) add(place.cut), add(place.cut_of_root);
    cuts_.assign(cuts, stream);
    for (SurfaceCell<Dim>& place : places)
        for (const CutCell<Dim>** cut : {&place.cut, &place.cut_of_root})
            if (*cut) *cut = cuts_.data() + at.at(*cut);
    places_.assign(places, stream);
    std::vector<OpenNode> nodes;
    for (const SurfaceNode<Dim>& n : plan_.surface_nodes) nodes.push_back({n.distance, n.capacity});
    open_nodes_.assign(nodes, stream);
    cells_.resize(places.size(), stream);
    sums_.resize(nodes.size() * node_reals, stream);
    acceleration_.resize(nodes.size(), stream);
    has_children_.resize(beds.size(), stream), has_roots_.resize(beds.size(), stream);
}

/// Those of a block's ring that are elements, behind one another.
template <class Real, int Dim>
void SurfaceState<Real, Dim>::upload_ring(cudaStream_t stream) {
    constexpr std::size_t nodes = SurfacePlan<Dim>::tile_nodes, cells = Block<Dim>::cells;
    std::vector<RingElement<Dim>> ring;
    std::vector<std::int32_t> first{0};
    std::vector<std::uint16_t> around(plan_.around.ring.size());
    std::vector<std::uint16_t> place(nodes);
    for (std::size_t k = 0; k < plan_.blocks.size(); ++k) {
        for (std::size_t n = 0; n < nodes; ++n) {
            if (!(plan_.ring[k * nodes + n].area > 0)) continue;
            place[n] = static_cast<std::uint16_t>(ring.size() - static_cast<std::size_t>(first.back()));
            ring.push_back(plan_.ring[k * nodes + n]);
        }
        first.push_back(static_cast<std::int32_t>(ring.size()));
        for (std::uint32_t i = plan_.around.first[k * cells]; i < plan_.around.first[(k + 1) * cells]; ++i)
            around[i] = place[plan_.around.ring[i]];
    }
    ring_.assign(ring, stream), first_ring_.assign(first, stream);
    around_.assign(around, stream), first_around_.assign(plan_.around.first, stream);
}

template <class Real, int Dim>
SurfaceTables<Dim> SurfaceState<Real, Dim>::tables() const {
    return {bed_of_.data(),
            giver_of_.data(),
            giver_.data(),
            first_element_.data(),
            first_slave_.data(),
            near_nodes_.data(),
            near_of_.data(),
            elements_.data(),
            slaves_.data(),
            ring_.data(),
            first_ring_.data(),
            around_.data(),
            first_around_.data(),
            givers_,
            static_cast<int>(plan_.near_nodes.size())};
}

template <class Real, int Dim>
unsigned SurfaceState<Real, Dim>::node_grid() const {
    constexpr std::size_t blocks = threads / Block<Dim>::cells;
    return static_cast<unsigned>((plan_.near_nodes.size() + blocks - 1) / blocks);
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::find_gaps(const View<Real, Dim>& view, const ContactField<Dim>& contact,
                                        const DeviceGaps<Dim>& gaps, const Array<ContactPair>& pairs,
                                        cudaStream_t stream) const {
    if (pairs.size() == 0) return;
    const SurfaceGapWork<Real, Dim> work{view, contact, tables(), pairs.data(), gaps.tiles(), gaps.bounds()};
    gaps_(static_cast<unsigned>(pairs.size()), stream, {work}, "Finding gaps of elements");
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::complete(SurfaceWork<Real, Dim>& work, const SurfaceTiles<Real>& tiles) const {
    work.tables = this->tables();
    work.tiles = tiles;
    work.shares = shares_.data();
    work.origin = method_.stencil.origin;
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::begin_step(SurfaceWork<Real, Dim> work, cudaStream_t stream) const {
    complete(work, {tiles_.data(), element_tiles_.data()});
    if (givers_ > 0) weigh_(static_cast<unsigned>(givers_), stream, {work}, "Weighing elements");
    if (node_grid() > 0) sum_(node_grid(), stream, {work}, "Summing shares of elements");
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::act(SurfaceWork<Real, Dim> work, double damping, cudaStream_t stream) const {
    if (givers_ == 0) return;
    const auto grid = static_cast<unsigned>(givers_);
    complete(work, {tiles_.data(), element_tiles_.data()});
    if (has_cells()) work.cells = cells_.data(), work.damping = damping;
    act_(grid, stream, {work}, "Acting on surfaces");
    apply_(node_grid(), stream, {work}, "Applying impulses of surfaces");
    if (slaves_.size() == 0) return;
    work.tiles.tile_of = slave_tiles_.data();
    close_(grid, stream, {work}, "Closing slaves");
    apply_(node_grid(), stream, {work}, "Applying impulses of slaves");
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::complete(OpenWork<Real, Dim>& work) const {
    complete(work, {tiles_.data(), cell_tiles_.data()});
    work.open = {{method_.context.walls, method_.capacity, method_.context.inverse_cell, std::pow(plan_.h, Dim - 1),
                  std::pow(plan_.h, Dim)},
                 places_.data(),
                 open_nodes_.data(),
                 cells_.data(),
                 sums_.data(),
                 acceleration_.data(),
                 has_children_.data(),
                 has_roots_.data()};
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::find_cells(OpenWork<Real, Dim> work, const Substep& first, cudaStream_t stream) const {
    if (givers_ == 0) return;
    complete(work);
    work.dt = first.dt, work.damping = first.damping();
    const auto grid = static_cast<unsigned>(givers_);
    keep_held_(node_grid(), stream, {work}, "Keeping what nodes hold");
    find_cells_(grid, stream, {work}, "Finding cells beside surfaces");
    sum_pass_(node_grid(), stream, {work}, "Summing children");
    close_cells_(grid, stream, {work}, "Closing cells beside surfaces");
    sum_pass_(node_grid(), stream, {work}, "Summing cells beside holes");
    fill_holes_(grid, stream, {work}, "Filling holes");
    sum_pass_(node_grid(), stream, {work}, "Summing roots");
}

/// Cells take what flowed in during the substep before; presses: and give their forces, else they are done.
template <class Real, int Dim>
void SurfaceState<Real, Dim>::advance(OpenWork<Real, Dim> work, const Substep& substep, bool presses,
                                      cudaStream_t stream) const {
    if (givers_ == 0) return;
    complete(work);
    work.dt = substep.dt, work.damping = substep.damping();
    work.half_time = 0.5 * (substep.number - 0.5) * substep.dt;
    work.takes_roots = substep.is_first(), work.updates = !substep.is_first(), work.presses = presses;
    press_(static_cast<unsigned>(givers_), stream, {work}, "Advancing cells beside surfaces");
    if (presses) hold_forces_(node_grid(), stream, {work}, "Summing forces of cells beside surfaces");
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::press(OpenWork<Real, Dim> work, const Substep& substep, cudaStream_t stream) const {
    advance(work, substep, true, stream);
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::find_fluxes(OpenWork<Real, Dim> work, cudaStream_t stream) const {
    if (givers_ == 0) return;
    complete(work);
    fluxes_(static_cast<unsigned>(givers_), stream, {work}, "Finding what flows into cells beside surfaces");
    sum_pass_(node_grid(), stream, {work}, "Summing fluxes");
}

template <class Real, int Dim>
void SurfaceState<Real, Dim>::finish(OpenWork<Real, Dim> work, const Substep& last, cudaStream_t stream) const {
    advance(work, {last.number + 1, last.count, last.dt}, false, stream);
}

template class SurfaceState<float, 2>;
template class SurfaceState<float, 3>;
template class SurfaceState<double, 2>;
template class SurfaceState<double, 3>;

}  // namespace moraine::gpu
