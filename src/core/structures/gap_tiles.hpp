#pragma once
// What the particles around a node tell it about a structure, and where it is read: partial minima and sums of blocks.
//
// Whole numbers, so that minima and sums are the same in any order (core/structures/particle_gaps.hpp has the
// formulas). A tile per block and structure that is near it; a block without particles has nothing in its tile, and is
// not read.

#include <cmath>

#include "core/data/grid_views.hpp"

namespace moraine {

/// Of one node and structure.
struct NodeGap {
    static constexpr std::int32_t none = 2147483647;
    static constexpr double gap_quanta = 16777216;   ///< per cell
    static constexpr double area_quanta = 33554432;  ///< per face of a cell; 128 of them fit

    std::int32_t gap = none;  ///< least signed distance of the soil [1 / gap_quanta cells]
    std::uint32_t area = 0;   ///< that bears, of the soil beside it [1 / area_quanta faces]

    static MORAINE_HD std::int32_t fixed(double cells) {
        using std::rint;
        const double most = 120;
        return static_cast<std::int32_t>(rint((cells < -most ? -most : (cells > most ? most : cells)) * gap_quanta));
    }
    static MORAINE_HD std::uint32_t fixed_area(double faces) {
        using std::rint;
        return static_cast<std::uint32_t>(rint(faces * area_quanta));
    }
    MORAINE_HD void add(const NodeGap& o) {
        if (o.gap < gap) gap = o.gap;
        area += o.area;
    }
    MORAINE_HD bool is_none() const { return gap == none; }
    MORAINE_HD double cells() const { return gap / gap_quanta; }
    MORAINE_HD double faces() const { return area / area_quanta; }
};

/// The tiles as the nodes read them.
struct GapTiles {
    int structures = 0;
    const std::int32_t* tile_of = nullptr;  ///< (own + ghosts) x structures: storage index, or -1: not near
    const NodeGap* tiles = nullptr;         ///< [tile][node of tile]
};

/// Of node n of node block c and structure k: over all occupied blocks whose tiles cover it. occupied: by block, as
/// TileView::tile_of.
template <int Dim>
MORAINE_HD NodeGap gap_at_node(const GapTiles& gaps, const BlockTable<Dim>& table, const std::int32_t* occupied,
                               int width, int c, int n, int k) {
    NodeGap all;
    const int side = tile_side(width);
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const int source = table.source[c * Block<Dim>::corners + delta];
        if (source < 0 || occupied[source] < 0) continue;
        const std::int32_t tile = gaps.tile_of[std::size_t(source) * std::size_t(gaps.structures) + std::size_t(k)];
        bool covers = tile >= 0;
        int at = 0;
        for (int a = Dim - 1; a >= 0; --a) {
            const int x = (n >> (2 * a)) & 3, upper = Block<Dim>::corner(delta, a);
            covers = covers && !(upper && x >= width - 1);
            at = at * side + x + 4 * upper;
        }
        if (covers) all.add(gaps.tiles[std::size_t(tile) * std::size_t(power<Dim>(side)) + std::size_t(at)]);
    }
    return all;
}

}  // namespace moraine
