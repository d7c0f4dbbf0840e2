#pragma once
// What of surfaces holds for an epoch (Bed::surface): which blocks and nodes they are near, which cells they cut, where
// the elements are and who is a slave. All of it follows from places, the same on all ranks, on hosts and on devices.

#include <vector>

#include "blocks/epoch.hpp"
#include "core/surfaces/open_rule.hpp"
#include "core/surfaces/surface_elements.hpp"
#include "core/surfaces/surface_geometry.hpp"

namespace moraine {

/// By own block and cell: who of the ring has an element and is the cell or beside it.
struct RingLists {
    std::vector<std::uint32_t> first;  ///< of `ring`, and their end
    std::vector<std::uint16_t> ring;
};

template <int Dim>
struct SurfacePlan {
    static constexpr int width = 3, cells = Block<Dim>::cells, nodes = power<Dim>(3);
    static constexpr int side = tile_side(width), tile_nodes = power<Dim>(side);
    static constexpr int to_middle = Dim == 2 ? 1 + side : 1 + side + side * side;  ///< of a stencil, in a tile
    using Place = Vec<std::int32_t, Dim>;

    double h;    ///< [m]
    int origin;  ///< of the stencil
    SurfaceGeometry<Dim> geometry{};
    ContactField<Dim> field{};
    std::size_t ghosts = 0;
    std::vector<std::int32_t> blocks{}, bed_of{};                     ///< own; by own and ghost block
    std::vector<std::int32_t> near_nodes{}, near_of{}, node_index{};  ///< node blocks; [block][node of tile]
    std::vector<SurfaceNode<Dim>> surface_nodes{};                    ///< [near node block][node]
    std::vector<SurfaceCell<Dim>> place_of{};                         ///< [block][cell]
    std::vector<std::vector<SurfaceElement<Dim>>> elements{};         ///< [block]
    std::vector<std::vector<Slave>> slaves{};                         ///< [block]
    std::vector<RingElement<Dim>> ring{};                             ///< [block][cell of the ring]
    RingLists around{};

    SurfacePlan(double cell, int of_stencil) : h(cell), origin(of_stencil) {}
    /// For the blocks of an epoch, by the geometry as it has begun. Not collective.
    void make(const EpochTables<Dim>& tables, const ContactField<Dim>& of);
    Place cell_node(int k, int c) const;
    std::int32_t node_at(int k, int n) const { return node_index[static_cast<std::size_t>(k * tile_nodes + n)]; }

  private:
    void list_blocks(const EpochTables<Dim>& tables);
    void find_nodes(const EpochTables<Dim>& tables);
    void find_block(int k);
    void find_space(int k, int c, const Place& node, SurfaceCell<Dim>& cell);
    void find_root(const Place& node, SurfaceCell<Dim>& cell);
    void add_element(int k, int c, const CutCell<Dim>& cut);
    void list_slaves(int k, int c);
    bool is_near(const Place& block) const;

    std::vector<Place> first_{};  ///< of blocks: the node of the first cell
};

}  // namespace moraine
