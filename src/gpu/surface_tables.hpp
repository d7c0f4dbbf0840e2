#pragma once
// The plan of surfaces on the device (blocks/surface_plan.hpp), and memory for what is summed there in a step. What a
// block finds is copied once and stays while the plan keeps it; of an epoch go lists of who is where, in one copy.

#include "blocks/surface_plan.hpp"
#include "core/transfer/method.hpp"
#include "gpu/kernels/surfaces/surface_work.hpp"
#include "gpu/memory/arena.hpp"

namespace moraine::gpu {

/// What blocks and node blocks find, by the plan's numbers.
template <int Dim>
class SurfaceStore {
  public:
    /// cells: those beside surfaces are wanted. Queued, in the order of the stream.
    void update(const SurfacePlan<Dim>& plan, bool cells, cudaStream_t stream);

    const SurfaceBed<Dim>& bed(const SurfaceBlock<Dim>& of) const { return beds_[of.number]; }
    const SpaceNode* nodes(const SurfaceNodes<Dim>& of) const { return nodes_[of.number]; }

  private:
    SurfaceBed<Dim> put(const SurfaceBlock<Dim>& block, bool cells, cudaStream_t stream);
    const SurfaceCell<Dim>* put_cells(const SurfaceBlock<Dim>& block, cudaStream_t stream);

    Arena memory_;
    std::vector<SurfaceBed<Dim>> beds_;
    std::vector<const SpaceNode*> nodes_;
    std::int64_t generation_ = -1;
};

template <class Real, int Dim>
class DeviceSurfaces {
  public:
    /// own: blocks; cells: those beside surfaces have a pressure. Asynchronous.
    void assign(const SurfacePlan<Dim>& plan, std::size_t own, bool cells, cudaStream_t stream);

    const SurfaceTables<Dim>& tables() const { return tables_; }
    OpenTables<Real, Dim> open_tables(const Method<Host, Real, Dim>& method, double cell) const;
    int givers() const { return givers_; }
    bool has_slaves() const { return has_slaves_; }
    Real* tiles() const { return tiles_.data(); }
    Real* shares() const { return shares_.data(); }
    const OpenCell<Real, Dim>* cells() const { return cells_.data(); }
    const SpaceNode* const* nodes() const { return node_at_; }
    const std::uint8_t* near_mark() const { return near_mark_; }  ///< by node block: a surface is near
    /// Who gives (SurfaceTiles).
    std::int32_t* element_tiles() const { return tile_of_.data(); }
    std::int32_t* slave_tiles() const { return tile_of_.data() + blocks_; }
    std::int32_t* cell_tiles() const { return tile_of_.data() + 2 * blocks_; }

  private:
    void put_lists(const SurfacePlan<Dim>& plan, cudaStream_t stream);
    void resize(std::size_t near_nodes, bool cells, cudaStream_t stream);

    SurfaceStore<Dim> store_;
    Arena lists_;
    SurfaceTables<Dim> tables_{};
    const SpaceNode* const* node_at_ = nullptr;
    const std::uint8_t* near_mark_ = nullptr;
    std::size_t blocks_ = 0;  ///< own and ghosts
    int givers_ = 0;
    bool has_slaves_ = false;
    PoolArray<Real> tiles_, shares_, sums_;
    PoolArray<std::int32_t> tile_of_;
    PoolArray<OpenCell<Real, Dim>> cells_;
    PoolArray<Vec<Real, Dim>> acceleration_;
    PoolArray<std::uint8_t> has_children_, has_roots_;
};

}  // namespace moraine::gpu
