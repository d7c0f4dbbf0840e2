#include "gpu/surface_tables.hpp"

#include <cmath>

namespace moraine::gpu {

template <int Dim>
void SurfaceStore<Dim>::update(const SurfacePlan<Dim>& plan, bool cells, cudaStream_t stream) {
    if (generation_ != plan.generation) memory_.clear(), beds_.clear(), nodes_.clear();
    generation_ = plan.generation;
    for (const SurfaceBlock<Dim>* block : plan.block_at) {
        if (block->number >= beds_.size()) beds_.push_back(put(*block, cells, stream));
    }
    for (const SurfaceNodes<Dim>* nodes : plan.nodes_at) {
        if (nodes->number >= nodes_.size()) nodes_.push_back(memory_.put(nodes->node, Block<Dim>::cells, stream));
    }
    memory_.flush(stream);
}

template <int Dim>
SurfaceBed<Dim> SurfaceStore<Dim>::put(const SurfaceBlock<Dim>& block, bool cells, cudaStream_t stream) {
    SurfaceBed<Dim> bed{};
    bed.element_count = static_cast<std::int32_t>(block.elements.size());
    bed.slave_count = static_cast<std::int32_t>(block.slaves.size());
    bed.elements = memory_.put(block.elements, stream);
    bed.slaves = memory_.put(block.slaves, stream);
    bed.ring = memory_.put(block.ring, stream);
    bed.around = memory_.put(block.around, stream);
    bed.first_around = memory_.put(block.first_around.data(), block.first_around.size(), stream);
    if (cells && block.has_cells) bed.cells = put_cells(block, stream);
    return bed;
}

template <int Dim>
const SurfaceCell<Dim>* SurfaceStore<Dim>::put_cells(const SurfaceBlock<Dim>& block, cudaStream_t stream) {
    std::vector<SurfaceCell<Dim>> cells = block.cell;
    for (SurfaceCell<Dim>& cell : cells)
        if (cell.cut) cell.cut = memory_.put(cell.cut, 1, stream);
    return memory_.put(cells, stream);
}

template <class Real, int Dim>
void DeviceSurfaces<Real, Dim>::assign(const SurfacePlan<Dim>& plan, std::size_t own, bool cells, cudaStream_t stream) {
    store_.update(plan, cells, stream);
    blocks_ = own + plan.ghosts;
    put_lists(plan, stream);
    resize(plan.near_nodes.size(), cells, stream);
}

template <class Real, int Dim>
void DeviceSurfaces<Real, Dim>::put_lists(const SurfacePlan<Dim>& plan, cudaStream_t stream) {
    std::vector<SurfaceBed<Dim>> beds(plan.blocks.size());
    std::vector<std::int32_t> giver;
    has_slaves_ = false;
    for (std::size_t k = 0; k < beds.size(); ++k) {
        SurfaceBed<Dim>& bed = beds[k] = store_.bed(*plan.block_at[k]);
        bed.block = plan.blocks[k];
        has_slaves_ = has_slaves_ || bed.slave_count > 0;
        if (bed.element_count > 0 || bed.slave_count > 0 || bed.cells) giver.push_back(static_cast<std::int32_t>(k));
    }
    std::vector<const SpaceNode*> node_at;
    for (const SurfaceNodes<Dim>* nodes : plan.nodes_at) node_at.push_back(store_.nodes(*nodes));
    std::vector<std::uint8_t> near_mark(plan.near_of.size());
    for (const std::int32_t c : plan.near_nodes) near_mark[static_cast<std::size_t>(c)] = 1;
    givers_ = static_cast<int>(giver.size());
    lists_.clear();
    tables_ = {lists_.put(beds, stream),         lists_.put(plan.bed_of, stream),
               lists_.put(giver, stream),        lists_.put(plan.near_nodes, stream),
               lists_.put(plan.near_of, stream), static_cast<int>(plan.near_nodes.size()),
               static_cast<int>(plan.ghosts)};
    node_at_ = lists_.put(node_at, stream);
    near_mark_ = lists_.put(near_mark, stream);
    lists_.flush(stream);
}

template <class Real, int Dim>
void DeviceSurfaces<Real, Dim>::resize(std::size_t near_nodes, bool cells, cudaStream_t stream) {
    const auto givers = static_cast<std::size_t>(givers_), nodes = near_nodes * Block<Dim>::cells;
    const std::size_t ghosts = static_cast<std::size_t>(tables_.ghosts);
    tiles_.resize((ghosts + givers) * SurfacePlan<Dim>::tile_nodes * node_reals, stream);
    shares_.resize(nodes * node_reals, stream);
    tile_of_.resize((cells ? 3 : 2) * blocks_, stream);
    if (tile_of_.size() > 0)
        check(cudaMemsetAsync(tile_of_.data(), 0xff, tile_of_.size() * sizeof(std::int32_t), stream),
              "Clearing tables of surfaces");
    if (!cells) return;
    cells_.resize(givers * Block<Dim>::cells, stream);
    sums_.resize(nodes * node_reals, stream);
    acceleration_.resize(nodes, stream);
    has_children_.resize(givers, stream), has_roots_.resize(givers, stream);
}

template <class Real, int Dim>
OpenTables<Real, Dim> DeviceSurfaces<Real, Dim>::open_tables(const Method<Host, Real, Dim>& method, double cell) const {
    return {{method.context.walls, method.capacity, method.context.inverse_cell, std::pow(cell, Dim - 1),
             std::pow(cell, Dim)},
            node_at_,
            cells_.data(),
            sums_.data(),
            acceleration_.data(),
            has_children_.data(),
            has_roots_.data()};
}

template class SurfaceStore<2>;
template class SurfaceStore<3>;
template class DeviceSurfaces<float, 2>;
template class DeviceSurfaces<float, 3>;
template class DeviceSurfaces<double, 2>;
template class DeviceSurfaces<double, 3>;

}  // namespace moraine::gpu
