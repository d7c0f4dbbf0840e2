#pragma once
// What surfaces cut in a block near them, and which nodes of its tile are slaves: by places alone (Bed::surface). It is
// found once, when a block first appears, and holds for as long as no structure moves.

#include <array>
#include <cstdint>
#include <vector>

#include "core/data/block.hpp"
#include "core/surfaces/open_rule.hpp"
#include "core/surfaces/surface_elements.hpp"
#include "core/surfaces/surface_geometry.hpp"

namespace moraine {

template <int Dim>
struct SurfaceBlock {
    static constexpr int cells = Block<Dim>::cells, side = tile_side(3), tile_nodes = power<Dim>(side);
    static constexpr int to_middle = Dim == 2 ? 1 + side : 1 + side + side * side;  ///< of a stencil, in a tile
    using Place = Vec<std::int32_t, Dim>;

    static constexpr std::size_t unused = ~std::size_t{0};
    std::size_t number = unused;           ///< of those that epochs of its plan have had (SurfacePlan::generation)
    Place first{};                         ///< node of its first cell
    std::vector<SurfaceCell<Dim>> cell{};  ///< none: pressures are the particles'
    std::vector<SurfaceElement<Dim>> elements{};
    std::vector<SlaveNode<Dim>> slaves{};
    std::vector<RingElement<Dim>> ring{};                 ///< elements of its cells and of those beside them
    std::vector<std::uint16_t> around{};                  ///< of `ring`: by cell, who is it or beside it
    std::array<std::uint16_t, cells + 1> first_around{};  ///< of `around`, and their end
    bool has_cells = false;                               ///< some cell is near a surface

    Place cell_node(int c) const {
        Place node = first;
        for (int a = 0; a < Dim; ++a) node[a] += (c >> (2 * a)) & 3;
        return node;
    }
};

/// The block whose first cell has that node; h [m].
template <int Dim>
SurfaceBlock<Dim> make_surface_block(const Vec<std::int32_t, Dim>& first, const ContactField<Dim>& field, double h,
                                     SurfaceGeometry<Dim>& geometry);

}  // namespace moraine
