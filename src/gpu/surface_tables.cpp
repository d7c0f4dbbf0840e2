#include "gpu/surface_tables.hpp"

#include <cmath>
#include <unordered_map>

namespace moraine::gpu {

template <class Real, int Dim>
void DeviceSurfaces<Real, Dim>::assign(const SurfacePlan<Dim>& plan, const std::vector<std::int32_t>& beds,
                                       std::size_t own, cudaStream_t stream) {
    constexpr std::size_t tile_reals = std::size_t(SurfacePlan<Dim>::tile_nodes) * node_reals;
    std::vector<std::int32_t> giver, first_element{0}, first_slave{0};
    std::vector<SurfaceElement<Dim>> elements;
    std::vector<SlaveNode<Dim>> slaves;
    for (const std::int32_t bed : beds) {
        const auto k = static_cast<std::size_t>(bed);
        giver.push_back(plan.blocks[k]);
        elements.insert(elements.end(), plan.elements[k].begin(), plan.elements[k].end());
        for (const Slave& s : plan.slaves[k])
            slaves.push_back({s, plan.surface_nodes[static_cast<std::size_t>(plan.node_at(bed, s.own))]});
        first_element.push_back(static_cast<std::int32_t>(elements.size()));
        first_slave.push_back(static_cast<std::int32_t>(slaves.size()));
    }
    giver_.assign(giver, stream);
    first_element_.assign(first_element, stream), first_slave_.assign(first_slave, stream);
    elements_.assign(elements, stream), slaves_.assign(slaves, stream);
    bed_of_.assign(plan.bed_of, stream);
    near_nodes_.assign(plan.near_nodes, stream), near_of_.assign(plan.near_of, stream);
    tiles_.resize(giver.size() * tile_reals, stream);
    shares_.resize(plan.near_nodes.size() * Block<Dim>::cells * node_reals, stream);
    const std::vector<std::int32_t> nobody(own + plan.ghosts, -1);
    element_tiles_.assign(nobody, stream), slave_tiles_.assign(nobody, stream);
    assign_ring(plan, stream);
}

/// Those of a block's ring that are elements, behind one another.
template <class Real, int Dim>
void DeviceSurfaces<Real, Dim>::assign_ring(const SurfacePlan<Dim>& plan, cudaStream_t stream) {
    constexpr std::size_t nodes = SurfacePlan<Dim>::tile_nodes, cells = Block<Dim>::cells;
    std::vector<RingElement<Dim>> ring;
    std::vector<std::int32_t> first{0};
    std::vector<std::uint16_t> around(plan.around.ring.size()), place(nodes);
    for (std::size_t k = 0; k < plan.blocks.size(); ++k) {
        for (std::size_t n = 0; n < nodes; ++n) {
            if (!(plan.ring[k * nodes + n].area > 0)) continue;
            place[n] = static_cast<std::uint16_t>(ring.size() - static_cast<std::size_t>(first.back()));
            ring.push_back(plan.ring[k * nodes + n]);
        }
        first.push_back(static_cast<std::int32_t>(ring.size()));
        for (std::uint32_t i = plan.around.first[k * cells]; i < plan.around.first[(k + 1) * cells]; ++i)
            around[i] = place[plan.around.ring[i]];
    }
    ring_.assign(ring, stream), first_ring_.assign(first, stream);
    around_.assign(around, stream), first_around_.assign(plan.around.first, stream);
}

template <class Real, int Dim>
SurfaceTables<Dim> DeviceSurfaces<Real, Dim>::tables() const {
    return {bed_of_.data(),
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
            static_cast<int>(near_nodes_.size())};
}

template <class Real, int Dim>
void DeviceOpenCells<Real, Dim>::assign(const SurfacePlan<Dim>& plan, const std::vector<std::int32_t>& beds,
                                        std::size_t own, cudaStream_t stream) {
    constexpr std::size_t cells = Block<Dim>::cells;
    std::vector<SurfaceCell<Dim>> places;
    for (const std::int32_t k : beds)
        for (std::size_t c = 0; c < cells; ++c)
            places.push_back(plan.place_of[static_cast<std::size_t>(k) * cells + c]);
    std::unordered_map<const CutCell<Dim>*, std::size_t> at;
    std::vector<CutCell<Dim>> cuts;
    for (const SurfaceCell<Dim>& place : places)
        for (const CutCell<Dim>* cut : {place.cut, place.cut_of_root})
            if (cut && at.emplace(cut, cuts.size()).second) cuts.push_back(*cut);
    cuts_.assign(cuts, stream);
    for (SurfaceCell<Dim>& place : places)
        for (const CutCell<Dim>** cut : {&place.cut, &place.cut_of_root})
            if (*cut) *cut = cuts_.data() + at.at(*cut);
    places_.assign(places, stream);
    std::vector<OpenNode> nodes;
    for (const SurfaceNode<Dim>& n : plan.surface_nodes) nodes.push_back({n.distance, n.capacity});
    nodes_.assign(nodes, stream);
    cells_.resize(places.size(), stream);
    sums_.resize(nodes.size() * node_reals, stream);
    acceleration_.resize(nodes.size(), stream);
    has_children_.resize(beds.size(), stream), has_roots_.resize(beds.size(), stream);
    tile_of_.assign(std::vector<std::int32_t>(own + plan.ghosts, -1), stream);
}

template <class Real, int Dim>
OpenTables<Real, Dim> DeviceOpenCells<Real, Dim>::tables(const Method<Host, Real, Dim>& method, double cell) const {
    return {{method.context.walls, method.capacity, method.context.inverse_cell, std::pow(cell, Dim - 1),
             std::pow(cell, Dim)},
            places_.data(),
            nodes_.data(),
            cells_.data(),
            sums_.data(),
            acceleration_.data(),
            has_children_.data(),
            has_roots_.data()};
}

#define MORAINE_SURFACES(Real, Dim)           \
    template class DeviceSurfaces<Real, Dim>; \
    template class DeviceOpenCells<Real, Dim>;
MORAINE_SURFACES(float, 2)
MORAINE_SURFACES(float, 3)
MORAINE_SURFACES(double, 2)
MORAINE_SURFACES(double, 3)

}  // namespace moraine::gpu
