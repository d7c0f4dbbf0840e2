#pragma once
// The plan of surfaces on the device (blocks/surface_plan.hpp), and memory for what is summed there in a step.

#include "blocks/surface_plan.hpp"
#include "core/transfer/method.hpp"
#include "gpu/compile/kernel.hpp"
#include "gpu/kernels/surfaces/surface_work.hpp"
#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

/// Of elements and slaves.
template <class Real, int Dim>
class DeviceSurfaces {
  public:
    /// beds: of blocks near a surface, the numbers of the givers. Asynchronous.
    void assign(const SurfacePlan<Dim>& plan, const std::vector<std::int32_t>& beds, std::size_t own,
                cudaStream_t stream);

    SurfaceTables<Dim> tables() const;
    int givers() const { return static_cast<int>(giver_.size()); }
    bool has_slaves() const { return slaves_.size() > 0; }
    Real* tiles() const { return tiles_.data(); }
    Real* shares() const { return shares_.data(); }
    std::int32_t* element_tiles() const { return element_tiles_.data(); }  ///< who gives (SurfaceTiles)
    std::int32_t* slave_tiles() const { return slave_tiles_.data(); }

  private:
    void assign_ring(const SurfacePlan<Dim>& plan, cudaStream_t stream);

    PoolArray<std::int32_t> bed_of_, giver_, first_element_, first_slave_, near_nodes_, near_of_, first_ring_;
    PoolArray<SurfaceElement<Dim>> elements_;
    PoolArray<SlaveNode<Dim>> slaves_;
    PoolArray<RingElement<Dim>> ring_;
    PoolArray<std::uint16_t> around_;
    PoolArray<std::uint32_t> first_around_;
    PoolArray<Real> tiles_, shares_;
    PoolArray<std::int32_t> element_tiles_, slave_tiles_;
};

/// Of cells beside surfaces, where the pressure is the grid's.
template <class Real, int Dim>
class DeviceOpenCells {
  public:
    /// As DeviceSurfaces'.
    void assign(const SurfacePlan<Dim>& plan, const std::vector<std::int32_t>& beds, std::size_t blocks,
                cudaStream_t stream);

    OpenTables<Real, Dim> tables(const Method<Host, Real, Dim>& method, double cell) const;
    const OpenCell<Real, Dim>* cells() const { return cells_.data(); }
    std::int32_t* tile_of() const { return tile_of_.data(); }  ///< who gives

  private:
    PoolArray<CutCell<Dim>> cuts_;
    PoolArray<SurfaceCell<Dim>> places_;
    PoolArray<OpenNode> nodes_;
    PoolArray<OpenCell<Real, Dim>> cells_;
    PoolArray<Real> sums_;
    PoolArray<Vec<Real, Dim>> acceleration_;
    PoolArray<std::uint8_t> has_children_, has_roots_;
    PoolArray<std::int32_t> tile_of_;
};

}  // namespace moraine::gpu
