#pragma once
// A block's nodes as sums of their tiles: +0 plus the tiles in the order of the offset delta, never of keys or ranks.

#include "core/data/grid_views.hpp"
#include "core/data/quad.hpp"

namespace moraine {

template <class Real, int Dim>
struct TileSums {
    Quad<Real> sums[2 * Block<Dim>::cells];
    std::int32_t counted_by[Block<Dim>::cells];  ///< first occupied source of the node, own or ghost; -1 none

    /// Of node block c.
    template <class Team>
    MORAINE_HD void find(const Team& team, const BlockTable<Dim>& table, const TileView<Real>& grid, int width, int c) {
        team.each(Block<Dim>::cells, [&](int n) {
            sums[2 * n] = sums[2 * n + 1] = Quad<Real>::zero();
            counted_by[n] = -1;
        });
        team.sync();
        for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
            const int source = table.source[c * Block<Dim>::corners + delta];
            const int tile = source < 0 ? -1 : grid.tile_of[source];
            if (tile < 0) continue;
            team.each(Block<Dim>::cells, [&](int n) { add(grid, width, n, delta, source, tile); });
            team.sync();
        }
    }

  private:
    MORAINE_HD void add(const TileView<Real>& grid, int width, int n, int delta, int source, int tile) {
        const int at = tile_node<Dim>(n, delta, width);
        if (at < 0) return;
        const Real* from = grid.tiles + (std::size_t(tile) * power<Dim>(tile_side(width)) + at) * node_reals;
        sums[2 * n] = sums[2 * n] + Quad<Real>::load(from);
        sums[2 * n + 1] = sums[2 * n + 1] + Quad<Real>::load(from + quad);
        if (counted_by[n] < 0) counted_by[n] = source;
    }
};

}  // namespace moraine
